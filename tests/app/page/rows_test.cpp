// Decimated rows and captures.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/page/capture.h"
#include "app/page/stream_rows.h"
#include "base/error.h"
#include "tests/app/page/two_axes.h"

namespace hystcan::app::rows_test {
namespace {

using nlohmann::json;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

StreamGreeting greeting_with(const std::vector<const char*>& columns) {
  StreamGreeting greeting;
  for (const char* column : columns) greeting.columns.push_back({column});
  return greeting;
}

RC_GTEST_PROP(RowDecimator, KeepsMinimumAndMaximumOfEachBucket, ()) {
  const auto bucket = *rc::gen::inRange<std::size_t>(1, 20);
  const auto values = *rc::gen::container<std::vector<int>>(rc::gen::inRange(-100, 100));
  RowDecimator decimator(greeting_with({"axis", "position_um"}), bucket);
  for (const int value : values)
    for (const double axis : {0.0, 1.0}) decimator.put(std::array{axis, axis == 0.0 ? value : -1.0 * value});
  const std::vector<double> out = decimator.take();
  std::vector<double> of_axis_0;
  for (std::size_t i = 0; i < out.size(); i += 2)
    if (out[i] == 0.0) of_axis_0.push_back(out[i + 1]);
  if (bucket <= 2) {
    RC_ASSERT(of_axis_0 == std::vector<double>(values.begin(), values.end()));
    return;
  }
  RC_ASSERT(of_axis_0.size() == values.size() / bucket * 2);
  for (std::size_t b = 0; b < values.size() / bucket; ++b) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(b * bucket);
    const auto [least, largest] = std::minmax_element(begin, begin + static_cast<std::ptrdiff_t>(bucket));
    RC_ASSERT(of_axis_0[2 * b] == *least);
    RC_ASSERT(of_axis_0[2 * b + 1] == *largest);
  }
}

TEST(RowDecimator, SendsAtMostTheRequestedRate) {
  for (const double rate : {10.0, 250.0, 500.0, 999.0, 1000.0})
    for (const double of : {100.0, 1000.0, 4000.0}) {
      const std::size_t bucket = RowDecimator::bucket_for(of, rate);
      EXPECT_LE(bucket <= 2 ? of : 2.0 * of / static_cast<double>(bucket),
                std::max(of <= rate ? of : rate, 0.0))
          << of << rate;
    }
}

TEST(RowDecimator, PrefersNumbersToNan) {
  RowDecimator decimator(greeting_with({"axis", "position_um"}), 3);
  for (const double value : {nan, 2.0, nan}) decimator.put(std::array{0.0, value});
  EXPECT_EQ(decimator.take(), (std::vector<double>{0.0, 2.0, 0.0, 2.0}));
  for (int i = 0; i < 3; ++i) decimator.put(std::array{0.0, nan});
  EXPECT_TRUE(std::isnan(decimator.take()[1]));
}

TEST(RowDecimator, KeepsEveryChangeOfStateAndLimit) {
  RowDecimator decimator(greeting_with({"axis", "state", "limits"}), 4);
  for (const double limits : {1.0, 4.0, 0.0, 2.0}) decimator.put(std::array{0.0, 5.0, limits});
  EXPECT_EQ(decimator.take(), (std::vector<double>{0, 5, 1, 0, 5, 7}));
  for (const double state : {4.0, 5.0, 5.0, 3.0}) decimator.put(std::array{0.0, state, 0.0});
  EXPECT_EQ(decimator.take(), (std::vector<double>{0, 4, 0, 0, 5, 0, 0, 5, 0})) << "3 is still open";
}

TEST(RowHistory, KeepsTheNewestRows) {
  RowHistory history(1, 3);
  for (const double value : {0.0, 1.0, 2.0, 3.0, 4.0}) history.put(std::array{value});
  EXPECT_EQ(history.first(), 2u);
  EXPECT_EQ(history.end(), 5u);
  for (std::uint64_t i = 2; i < 5; ++i) EXPECT_EQ(history.row(i)[0], static_cast<double>(i));
}

const StreamGreeting greeting = two_axes();

/// Two axes at 1 kHz, with the position of axis 0 from a function of the time in ms.
class Stream {
 public:
  explicit Stream(const json& request) : trigger_(request, greeting) {}

  void run(int from_ms, int to_ms, const std::function<double(int)>& position,
           const std::function<double(int)>& fault = {}) {
    for (int i = from_ms; i < to_ms; ++i)
      for (const double axis : {0.0, 1.0}) {
        const std::array row{0.001 * i, axis, 4.0,         fault ? fault(i) : 0.0, position(i), nan,
                             1.0,       1.0,  position(i), missing(i) ? 1.0 : 0.0};
        history_.put(row);
        if (auto capture = trigger_.put(row, history_)) captures.push_back(*capture);
      }
  }
  std::vector<Capture> captures;
  std::function<bool(int)> missing = [](int) { return false; };

 private:
  Trigger trigger_;
  RowHistory history_{10, 100'000};
};

json request_for(const char* on, json further = json::object()) {
  json request{{"on", on}, {"axis", 0}, {"pre_s", 0.01}, {"post_s", 0.02}};
  request.update(further);
  return request;
}

TEST(Capture, ContainsRowsBeforeAndAfterTheTrigger) {
  Stream stream(request_for("step", {{"level", 0.5}}));
  stream.run(0, 200, [](int i) { return i < 100 ? 0.0 : 1.0; });
  ASSERT_EQ(stream.captures.size(), 1u);
  EXPECT_DOUBLE_EQ(stream.captures[0].trigger_time_s, 0.1);
  EXPECT_EQ(stream.captures[0].trigger_row, 10u);
  EXPECT_EQ(stream.captures[0].rows.size(), 31u * 10) << "of axis 0 only";
}

TEST(Capture, HasTheFiguresOfItsStep) {
  Stream stream(request_for("step", {{"level", 0.5}, {"post_s", 0.1}}));
  stream.run(0, 300, [](int i) { return i < 100 ? 2.0 : 12.0; });
  ASSERT_EQ(stream.captures.size(), 1u);
  const json step = step_of(stream.captures[0], CycleColumns::of(greeting), 0.0);
  EXPECT_EQ(step.at("from_um"), 2.0);
  EXPECT_EQ(step.at("to_um"), 12.0);
  EXPECT_EQ(step.at("band_um"), 0.1);
  EXPECT_EQ(step.at("settling_s"), 0.0);
  EXPECT_NEAR(step.at("judged_s"), 0.1, 1e-9);
}

TEST(Capture, ExcludesMissingSamplesFromItsStep) {
  Stream stream(request_for("step", {{"level", 0.5}, {"post_s", 0.1}}));
  stream.missing = [](int i) { return i < 110; };
  stream.run(0, 300, [](int i) { return i < 100 ? 2.0 : 12.0; });
  ASSERT_EQ(stream.captures.size(), 1u);
  EXPECT_NEAR(step_of(stream.captures[0], CycleColumns::of(greeting), 0.0).at("settling_s"), 0.01, 1e-9);
}

TEST(Capture, HasNoStepIfThereIsNoneAtTheTrigger) {
  Stream stream(request_for("now"));
  stream.run(0, 100, [](int) { return 1.0; });
  ASSERT_GE(stream.captures.size(), 1u);
  EXPECT_TRUE(step_of(stream.captures[0], CycleColumns::of(greeting), 0.0).is_null());
}

TEST(Capture, TriggersAtTheEdgeOfALevel) {
  const auto triangle = [](int i) { return i % 400 < 200 ? i % 400 : 400 - i % 400; };
  for (const auto& [edge, time_s] :
       {std::pair("rising", 0.1), std::pair("falling", 0.3), std::pair("either", 0.1)}) {
    Stream stream(request_for("level", {{"signal", "position_um"}, {"level", 100}, {"edge", edge}}));
    stream.run(0, 350, triangle);
    ASSERT_GE(stream.captures.size(), 1u) << edge;
    EXPECT_DOUBLE_EQ(stream.captures[0].trigger_time_s, time_s) << edge;
  }
}

TEST(Capture, TriggersAtAFault) {
  Stream stream(request_for("fault"));
  stream.run(
      0, 100, [](int) { return 0.0; }, [](int i) { return i < 50 ? 0.0 : 13.0; });
  ASSERT_EQ(stream.captures.size(), 1u);
  EXPECT_DOUBLE_EQ(stream.captures[0].trigger_time_s, 0.05);
}

TEST(Capture, IsLimitedToFivePerSecondIfRepeated) {
  Stream stream(request_for("now", {{"pre_s", 0}, {"post_s", 0}, {"repeat", true}}));
  stream.run(0, 1000, [](int) { return 0.0; });
  EXPECT_LE(stream.captures.size(), 5u) << "at most five a second, whatever is asked";
  EXPECT_GE(stream.captures.size(), 4u);
}

TEST(Capture, RefusesAnInvalidTrigger) {
  for (const json& wrong :
       {request_for("dance"), request_for("step"), request_for("now", {{"axis", 2}}),
        request_for("now", {{"axis", -1}}), request_for("now", {{"axis", 0.5}}),
        request_for("now", {{"pre_s", 6}, {"post_s", 6}}), request_for("now", {{"post_s", -1}}),
        request_for("level", {{"level", 1}, {"signal", "no_um"}}),
        request_for("level", {{"level", 1}, {"signal", "position_um"}, {"edge", "up"}})})
    EXPECT_THROW(Trigger(wrong, greeting), Error) << wrong;
}

}  // namespace
}  // namespace hystcan::app::rows_test
