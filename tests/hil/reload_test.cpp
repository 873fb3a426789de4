// The configuration file of a running controller, changed: taken over between two cycles without a jump on
// the wire, or not at all and with the reason.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/hil/live_stage.h"
#include "tests/support/drive_step.h"

namespace hystcan::reload_test {
namespace {

using hil::between;
using hil::json;
using hil::LiveStage;
using hil::milliseconds;
using hil::now_s;
using hil::OnWire;
using hil::series;

/// Replaces the first occurrence in the file, which is that of x. As most editors do, it puts another file in
/// the place of the old one.
void replace(const support::ShippedCopy& files, const std::string& what, const std::string& with) {
  std::filesystem::copy_file(files / "piezo.toml", files / "piezo.toml.new");
  files.edit("piezo.toml.new", what, with);
  std::filesystem::rename(files / "piezo.toml.new", files / "piezo.toml");
}

std::size_t count_in(const std::string& log, const std::string& text) {
  std::size_t times = 0;
  for (auto at = log.find(text); at != std::string::npos; at = log.find(text, at + 1)) ++times;
  return times;
}

TEST(Reload, GainsStructureLimitsAndSetpointChangeWithoutAJumpAndAreLoggedAsADiff) {
  LiveStage stage;
  stage.start();
  const double tracking_s = now_s();
  std::this_thread::sleep_for(milliseconds(2600));  // one pass of the reference
  struct Step {
    const char* what;
    const char* with;
    const char* diff;
    bool in_place;
  };
  const std::vector<Step> steps{
      {"= 0.0          # um per um", "= 0.08", "axis[0].control.kp: 0 -> 0.08", false},
      {"\"inverse+pi\"", "\"average+pi\"", "axis[0].control.structure: 'inverse+pi' -> 'average+pi'", true},
      {"high_um      = 27.0", "high_um = 21.0", "axis[0].control.setpoint[0].high_um: 27 -> 21", false}};
  std::vector<double> changed_s;
  for (const Step& step : steps) {
    step.in_place ? stage.files.edit("piezo.toml", step.what, step.with)
                  : replace(stage.files, step.what, step.with);
    EXPECT_TRUE(stage.bench.controller->says(step.diff)) << step.diff << "\n"
                                                         << stage.bench.controller->err();
    changed_s.push_back(now_s());
    std::this_thread::sleep_for(milliseconds(250));
  }
  std::this_thread::sleep_for(milliseconds(800));
  EXPECT_LT(std::abs(stage.axis_status(0).at("error_um").get<double>()), 1.0)
      << "of average+pi, 0.3 um RMS, at any phase of the triangle";
  EXPECT_EQ(count_in(stage.bench.controller->err(), "configuration: "), steps.size())
      << "and nothing else: " << stage.bench.controller->err();

  // At whatever phase of the reference each was taken over: tests/closed_loop/reload_test.cpp tries all.
  const json log = stage.bench.decoded_with_series();
  const std::vector<OnWire> commands = series(log, "X", "AmpCommand");
  const double usual_V = hil::largest_step(between(commands, tracking_s, changed_s.front() - 0.2));
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double step_V = hil::largest_step(between(commands, changed_s[i] - 0.2, changed_s[i] + 0.2));
    std::printf("%s: largest step of the drive %.3f V, before any change %.3f V\n", steps[i].diff, step_V,
                usual_V);
    EXPECT_GT(step_V, 0.0);
    EXPECT_LT(step_V, support::fair_share_of_own_step * usual_V) << steps[i].diff;
  }
  EXPECT_EQ(log.at("axis_states").at("X").back(), "tracking") << log.at("axis_states");
  EXPECT_TRUE(log.at("first_fault").is_null());
}

}  // namespace
}  // namespace hystcan::reload_test
