// Changes the running configuration at every phase of the reference: the drive makes no step that the
// references do not cause themselves. On a bench the phase depends on when the file is saved; this test
// covers all phases.
//
//                                      in the triangle          in the staircase
//   largest step, largest error        V        um              V        um
//   no change                          2.96     0.136           4.88     0.133
//   high_um 27 -> 21                   2.96     0.139           4.88     0.144
//   without limits of transitions      2.96     0.288           4.88     0.549
//   without regard to the preview      6.50                     4.88
//   without either                     6.55                    14.4
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/drive_step.h"
#include "tests/support/long_run.h"
#include "tests/support/rehearsed.h"

namespace hystcan::reload_test {
namespace {

using controller::AxisState;
using controller::Request;
using std::chrono::milliseconds;

const std::string file = HYSTCAN_SOURCE_DIR "/config/piezo.toml";
constexpr double cycle_s = 1e-3;
constexpr double triangle_um_per_s = 480.0;    // 24 um up and down again, ten times per second
constexpr double staircase_um_per_s = 1375.0;  // 15/8 of 22 um in 30 ms
/// PI's contribution to the change in one cycle: twice kp and once ki T of an error of 0.2 um.
constexpr double pi_um = (2.0 * 0.08 + 409.0 * cycle_s) * 0.2;
/// With the default limit of acceleration the mode lags by a thousandth of the stroke: when the reference
/// brakes, when the transition starts and when it ends; in the worst case all at once.
constexpr double mode_um = 3.0 * 28.5e-3;

config::AxisConfig axis_with(const std::vector<config::Setting>& settings) {
  return config::load(file, settings).axes[0];
}

/// Axis x of the shipped stage, tracking.
class Tracking {
 public:
  Tracking() {
    static const config::Config config = config::load(file);
    rehearsal::Setup setup = support::setup_of(config);
    setup.controller.axes.resize(1);
    setup.twin.axes.resize(1);
    rehearsal_ = std::make_unique<rehearsal::Rehearsal>(
        setup, [this](const controller::CycleRecord& record) { reports_.push_back(record.report); });
    rehearsal_->controller().listen_to(requests_);
    rehearsal_->start();
    for (int i = 0; i < 3000 && axis().state() != AxisState::tracking; ++i) run_for_ms(1);
    EXPECT_EQ(axis().state(), AxisState::tracking);
    reports_.clear();
  }

  /// Carries the request out between two cycles.
  void ask(std::unique_ptr<Request> request) {
    ASSERT_TRUE(requests_.ask(std::move(request)));
    run_for_ms(2);
    const auto answer = requests_.take_answer();
    ASSERT_NE(answer, nullptr);
    ASSERT_EQ(answer->refusal, std::nullopt);
  }
  void run_for_ms(int ms) { rehearsal_->run_for(milliseconds(ms)); }
  const controller::Axis& axis() const { return rehearsal_->controller().axis(0); }
  const std::vector<controller::AxisReport>& reports() const { return reports_; }

 private:
  std::vector<controller::AxisReport> reports_;
  controller::RequestLink requests_;
  std::unique_ptr<rehearsal::Rehearsal> rehearsal_;
};

/// The largest steps of a run.
struct Steps {
  double drive_V = 0.0;
  double demand_um = 0.0;
  double error_um = 0.0;  ///< largest following error; not a step
};

/// Returns the largest steps from the report `first` on.
Steps largest_steps(const std::vector<controller::AxisReport>& reports, std::size_t first) {
  std::vector<double> drives, demands;
  double error_um = 0.0;
  for (std::size_t i = first; i < reports.size(); ++i) {
    drives.push_back(reports[i].drive);
    demands.push_back(reports[i].demand_um);
    error_um = std::max(error_um, std::abs(reports[i].reference_um - reports[i].position_um));
  }
  return {support::largest_step(drives), support::largest_step(demands), error_um};
}

/// A part of the reference, in ms since tracking began, and the speed that it requires by itself.
struct Part {
  const char* name;
  int from_ms, to_ms, every_ms;
  double slope_um_per_s;
};
/// All hundred cycles of one period, after the first periods have settled.
constexpr Part triangle{"triangle", 500, 600, 1, triangle_um_per_s};
/// Its rises of 30 ms every 80 ms, at phases that shift through the rises.
constexpr Part staircase{"staircase", 1300, 2000, 7, staircase_um_per_s};

/// Returns the steps of the drive in this part without a change.
Steps own_steps(const Part& part) {
  Tracking run;
  run.run_for_ms(part.from_ms - 100);
  const std::size_t first = run.reports().size();
  run.run_for_ms(part.to_ms - part.from_ms + 100);
  return largest_steps(run.reports(), first);
}

struct Change {
  const char* name;
  std::vector<config::Setting> settings;
  bool new_reference = false;
  bool as_fast_as_it_may = false;  ///< the transition into it is limited only by the default limits
  bool another_structure = false;
};
void PrintTo(const Change& change, std::ostream* out) { *out << change.name; }

/// Returns the top speed of a transition of 26 um with the default limits.
double fastest_transition_um_per_s() {
  const controller::ReferenceLimits limits = axis_with({}).control.transition_limits;
  return controller::Transition::within(limits, {.value_um = 3.0}, 29.0, 1e-3).peak_slew_um_per_s();
}

class ReloadAtEveryPhase : public testing::TestWithParam<Change> {
 protected:
  void stays_fair(const Part& part) const {
    const Change& change = GetParam();
    const config::AxisConfig next = axis_with(change.settings);
    const Steps own = own_steps(part);
    const double slope_um_per_s =
        change.as_fast_as_it_may ? fastest_transition_um_per_s() : part.slope_um_per_s;
    const double fair_V = support::fair_share_of_own_step * own.drive_V;
    const int every_ms = support::long_run() ? part.every_ms : 7 * part.every_ms;
    Steps worst;
    for (int phase_ms = part.from_ms; phase_ms < part.to_ms; phase_ms += every_ms) {
      Tracking run;
      run.run_for_ms(phase_ms);
      const std::size_t first = run.reports().size() - 5;
      auto request = std::make_unique<Request>();
      request->kind = Request::Kind::retune;
      request->tuning = std::make_unique<controller::AxisTuning>(next.control, change.new_reference);
      run.ask(std::move(request));
      run.run_for_ms(60);
      ASSERT_EQ(run.axis().state(), AxisState::tracking) << phase_ms;
      const Steps steps = largest_steps(run.reports(), first);
      if (!change.as_fast_as_it_may) {
        EXPECT_LT(steps.drive_V, fair_V) << part.name << ", " << phase_ms << " ms";
      }
      if (!change.another_structure) {
        EXPECT_LT(steps.demand_um, slope_um_per_s * cycle_s + pi_um)
            << part.name << ", " << phase_ms << " ms";
      }
      if (change.new_reference) {
        EXPECT_LT(steps.error_um, own.error_um + mode_um) << part.name << ", " << phase_ms << " ms";
      }
      for (const controller::AxisReport& report : run.reports())
        ASSERT_EQ(report.limits & controller::limit::slew, 0) << part.name << ", " << phase_ms << " ms";
      worst.drive_V = std::max(worst.drive_V, steps.drive_V);
      worst.demand_um = std::max(worst.demand_um, steps.demand_um);
      worst.error_um = std::max(worst.error_um, steps.error_um);
    }
    std::printf(
        "%s in the %s: largest steps %.3f V, %.3f um, error %.3f um; without a change %.3f V, %.3f um, %.3f "
        "um\n",
        change.name, part.name, worst.drive_V, worst.demand_um, worst.error_um, own.drive_V, own.demand_um,
        own.error_um);
  }
};

TEST_P(ReloadAtEveryPhase, AddsNoStepToATriangle) { stays_fair(triangle); }

TEST_P(ReloadAtEveryPhase, AddsNoStepToAStaircase) { stays_fair(staircase); }

INSTANTIATE_TEST_SUITE_P(
    All, ReloadAtEveryPhase,
    testing::Values(
        Change{.name = "SmallerTriangle",
               .settings = {{"axis[0].control.setpoint[0].high_um", "21.0"}},
               .new_reference = true},
        Change{.name = "OtherEndOfTheStroke",
               .settings = {{"axis[0].control.setpoint[0].low_um", "29.0"},
                            {"axis[0].control.setpoint[0].high_um", "29.5"}},
               .new_reference = true},
        Change{.name = "OtherEndOfTheStrokeAtOnce",
               .settings = {{"axis[0].control.setpoint[0].low_um", "29.0"},
                            {"axis[0].control.setpoint[0].high_um", "29.5"},
                            {"axis[0].control.setpoint[0].transition_s", "0.001"}},
               .new_reference = true,
               .as_fast_as_it_may = true},
        Change{.name = "WithLimitsOfItsOwn",
               .settings = {{"axis[0].control.setpoint[0].high_um", "21.0"},
                            {"axis[0].control.reference_slew_um_per_s", "1400.0"},
                            {"axis[0].control.reference_acceleration_um_per_s2", "1.5e5"}},
               .new_reference = true},
        Change{.name = "Gains",
               .settings = {{"axis[0].control.kp", "0.08"}, {"axis[0].control.ki_per_s", "90.0"}}},
        Change{.name = "Delays", .settings = {{"axis[0].control.delays.second_order", "true"}}},
        Change{.name = "PlantInverse", .settings = {{"axis[0].control.delays.plant_inverse", "true"}}},
        Change{.name = "Structure",
               .settings = {{"axis[0].control.structure", "\"average+pi\""}},
               .another_structure = true}),
    [](const auto& test) { return test.param.name; });

/// The transitions to a live goal and back are new references too.
TEST(LiveGoalAtEveryPhase, AddsNoStepToATriangle) {
  const Steps own = own_steps(triangle);
  for (int phase_ms = triangle.from_ms; phase_ms < triangle.to_ms; ++phase_ms) {
    Tracking run;
    run.run_for_ms(phase_ms);
    const std::size_t first = run.reports().size() - 5;
    auto request = std::make_unique<Request>();
    request->kind = Request::Kind::go_to;
    request->position_um = 12.5;
    run.ask(std::move(request));
    run.run_for_ms(phase_ms % 50);  // during the transition
    request = std::make_unique<Request>();
    request->kind = Request::Kind::resume;
    run.ask(std::move(request));
    run.run_for_ms(60);
    const Steps steps = largest_steps(run.reports(), first);
    EXPECT_LT(steps.drive_V, support::fair_share_of_own_step * own.drive_V) << phase_ms << " ms";
    EXPECT_LT(steps.demand_um, triangle_um_per_s * cycle_s + pi_um) << phase_ms << " ms";
    EXPECT_LT(steps.error_um, own.error_um + mode_um) << phase_ms << " ms";
  }
}

// The triangle moves by 0.48 um per cycle, and a sample shows its position of 5 ms ago.
TEST(RequestToGoElsewhere, KeepsTheReferenceOfSamplesInTransit) {
  const rehearsal::Setup setup =
      support::shipped("piezo.toml", {{"axis[0].control.delays.sensor_delay_us", "5000.0"},
                                      {"axis[0].control.ki_per_s", "80.0"},
                                      {"axis[0].twin.sensor.delay_us", "5000.0"}});
  for (int phase_ms = 0; phase_ms < 100; phase_ms += 7) {
    std::vector<double> references_um;
    rehearsal::Rehearsal loop(setup, [&](const controller::CycleRecord& record) {
      if (record.axis == 0 && record.report.state == AxisState::tracking)
        references_um.push_back(record.report.reference_um);
    });
    controller::RequestLink requests;
    loop.controller().listen_to(requests);
    loop.start();
    loop.run_for(milliseconds(1700 + phase_ms));
    for (const Request::Kind kind : {Request::Kind::go_to, Request::Kind::resume}) {
      auto request = std::make_unique<Request>();
      request->kind = kind;
      request->position_um = 15.0;
      ASSERT_TRUE(requests.ask(std::move(request)));
      loop.run_for(milliseconds(500));
      const auto answer = requests.take_answer();
      ASSERT_NE(answer, nullptr);
      EXPECT_EQ(answer->refusal, std::nullopt);
    }
    ASSERT_GT(references_um.size(), 1000u);
    EXPECT_LT(support::largest_step(references_um), 1.5 * 0.48) << phase_ms;
  }
}

}  // namespace
}  // namespace hystcan::reload_test
