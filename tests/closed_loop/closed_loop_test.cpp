// Controller and twin on the simulated bus with the shipped configurations; frames are encoded and decoded
// in both directions.
//
//   80 % stroke triangle, 10 Hz, 1 kHz cycle; the twin differs by 3 % in the curves and 20 % in k
//
//   structure               average   inverse   pi      average+pi   inverse+pi
//   RMS error, % of stroke  5.20      0.95      4.5     0.94         0.095
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/count_allocations.h"
#include "tests/support/rehearsed.h"

namespace hystcan::closed_loop_test {
namespace {

using controller::AxisState;
using controller::Structure;
using support::ignore;
using support::shipped;
using support::triangle_percent;

TEST(PiezoStage, TracksWithinItsBudgetWithAMismatchedModel) {
  const rehearsal::Setup setup = shipped("piezo.toml");
  std::map<Structure, double> percent;
  for (const Structure structure : controller::all_structures) {
    const rehearsal::Outcome outcome = rehearsal::run_once(with_structure(setup, structure), 0.1, ignore);
    for (const auto& axis : outcome.axes)
      ASSERT_EQ(axis.state, AxisState::tracking) << to_string(axis.fault.cause);
    EXPECT_EQ(outcome.counters.missing_samples, 0u);
    percent[structure] = triangle_percent(outcome);
  }
  EXPECT_LE(percent[Structure::inverse_pi], 0.10);
  EXPECT_GE(percent[Structure::pi] / percent[Structure::inverse_pi], 20.0);
  EXPECT_GE(percent[Structure::average_pi] / percent[Structure::inverse_pi], 5.0);
  EXPECT_LT(percent[Structure::inverse], percent[Structure::average]);
}

TEST(PiezoStage, TracksToTheSensorNoiseAtRestWithAPerfectModel) {
  rehearsal::Setup setup = shipped("piezo.toml");
  for (std::size_t i = 0; i < setup.twin.axes.size(); ++i) {
    setup.twin.axes[i].axis.plant.hysteresis = setup.controller.axes[i].axis.law.model;
    setup.controller.axes[i].axis.setpoint = {
        {.shape = controller::Hold{.level_um = 12.0, .duration_s = 0.5}, .transition_s = 0.2}};
  }
  const auto outcome = rehearsal::run_once(with_structure(setup, Structure::inverse), 0.2, ignore);
  EXPECT_LT(outcome.axes[0].statistics.total().rms_um(), 3 * setup.twin.axes[0].axis.sensor.noise_um_rms);
}

TEST(Galfenol, IsTrackedThroughItsButterflyCurve) {
  const rehearsal::Setup setup = shipped("galfenol.toml");
  const auto inverse = rehearsal::run_once(with_structure(setup, Structure::inverse_pi), 0.1, ignore);
  const auto average = rehearsal::run_once(with_structure(setup, Structure::average_pi), 0.1, ignore);
  EXPECT_LE(triangle_percent(inverse), 0.3);
  EXPECT_GE(triangle_percent(average) / triangle_percent(inverse), 2.0);
}

/// The piezo stage with a butterfly curve of a coercive material, from -30 V. The branches cross near -28 and
/// 28 V.
rehearsal::Setup butterfly_stage() {
  const model::Interval range{-100.0, 100.0};
  const auto butterfly = [&](double share) {
    model::HysteresisParameters p{.input_unit = "V",
                                  .output_unit = "um",
                                  .ascending = {model::Basis::power, {-0.3, 0.01, 3e-5}, range},
                                  .descending = {model::Basis::power, {0.3, 0.01, -3e-5}, range},
                                  .k_ascending = 0.005 * share,
                                  .k_descending = 0.005 * share};
    p.output_map.emplace(std::vector<double>{15.0, 0.0, 15.0}, model::Interval{-1.0, 1.0});
    return p;
  };
  rehearsal::Setup setup = shipped("piezo.toml");
  for (std::size_t i = 0; i < setup.twin.axes.size(); ++i) {
    setup.twin.axes[i].axis.plant.hysteresis = butterfly(0.8);
    setup.controller.axes[i].axis.law.model = butterfly(1.0);
    setup.controller.axes[i].axis.gate.drive_min = -30.0;
  }
  return setup;
}

TEST(Butterfly, IsTrackedBeyondTheValleyOfACoerciveLoop) {
  const rehearsal::Setup setup = butterfly_stage();
  double lowest_drive = 0.0;
  const auto outcome =
      rehearsal::run_once(with_structure(setup, Structure::inverse_pi), 0.3, [&](const auto& record) {
        if (record.report.state == AxisState::tracking)
          lowest_drive = std::min(lowest_drive, record.report.drive);
      });
  for (const auto& axis : outcome.axes)
    ASSERT_EQ(axis.state, AxisState::tracking) << to_string(axis.fault.cause);
  EXPECT_GE(lowest_drive, -30.0);
  const auto average = rehearsal::run_once(with_structure(setup, Structure::average_pi), 0.3, ignore);
  EXPECT_GE(triangle_percent(average) / triangle_percent(outcome), 2.0);
  EXPECT_LE(triangle_percent(outcome), 0.5);
}

TEST(Rehearsal, RepeatsToTheBitWithTheSameSeed) {
  const auto positions = [](std::uint64_t seed) {
    rehearsal::Setup setup = shipped("piezo.toml");
    setup.twin.seed = seed;
    std::vector<double> result;
    rehearsal::run_once(setup, 0.1, [&](const auto& record) { result.push_back(record.report.position_um); });
    return result;
  };
  const auto first = positions(1);
  EXPECT_EQ(first, positions(1));
  EXPECT_NE(first, positions(2));
}

TEST(Rehearsal, LoadsTheBusByLessThanTwoThirds) {
  EXPECT_LT(rehearsal::run_once(shipped("piezo.toml"), 0.1, ignore).bus_load, 2.0 / 3.0);
}

// Controller, twin and simulated bus: two axes, real instruments, a laboratory's frames, axes that share a
// frame.
TEST(TrackingLoop, AllocatesNothing) {
  for (const char* file :
       {"piezo.toml", "p733.toml", "galfenol_unimorph.toml", "lab_amplifier.toml", "fd_stage.toml"})
    EXPECT_EQ(support::allocations_while_tracking(shipped(file)), 0u) << file;
}

TEST(OpenLoop, AllocatesNothingAndReachesTheHighestDriveOfTheExcitation) {
  rehearsal::Setup setup = shipped("piezo.toml");
  setup.controller.axes.resize(1);
  setup.controller.axes[0].axis.excitation = controller::Excitation::Hysteresis{.low = 10.0, .high = 70.0};
  double highest = 0.0;
  rehearsal::Rehearsal rehearsal(setup, [&](const auto& r) { highest = std::max(highest, r.report.drive); });
  rehearsal.start();
  rehearsal.run_for(std::chrono::seconds(2));
  ASSERT_EQ(rehearsal.controller().axis(0).state(), AxisState::tracking);
  const std::uint64_t before = support::allocations_so_far();
  rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(support::allocations_so_far(), before);
  EXPECT_EQ(highest, 70.0);
  EXPECT_EQ(rehearsal.twin().axes()[1]->amplifier.state(), can::AmpState::off)
      << "the other axis is not driven";
}

}  // namespace
}  // namespace hystcan::closed_loop_test
