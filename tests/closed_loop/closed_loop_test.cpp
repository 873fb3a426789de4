// Controller and twin on the simulated bus with the shipped configurations; frames are encoded and decoded
// both ways.
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
using controller::Cause;
using controller::Structure;
using std::chrono::milliseconds;
using support::ignore;
using support::shipped;
using support::triangle_percent;

TEST(PiezoStage, MeetsItsTrackingBudgetWithAMismatchedModel) {
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

TEST(PiezoStage, AtRestIsTrackedToTheSensorNoiseWithAPerfectModel) {
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

/// The piezo stage with a butterfly of a material with coercivity, from -30 V. The branches cross near -28
/// and 28 V.
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

TEST(Butterfly, WithCoercivityIsTrackedOnTheSideBeyondItsValley) {
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

/// A loop that tracks.
class TrackingLoop : public testing::Test {
 protected:
  TrackingLoop() {
    rehearsal_.start();
    for (int i = 0; i < 300 && state(0) != AxisState::tracking; ++i) rehearsal_.run_for(milliseconds(10));
    rehearsal_.run_for(milliseconds(400));
  }
  AxisState state(std::size_t axis) { return rehearsal_.controller().axis(axis).state(); }
  Cause cause(std::size_t axis) { return rehearsal_.controller().axis(axis).fault().cause; }
  const twin::Axis& stage(std::size_t axis) { return *rehearsal_.twin().axes()[axis]; }

  rehearsal::Rehearsal rehearsal_{shipped("piezo.toml"), ignore};
};

TEST_F(TrackingLoop, FaultsWithItsCauseWithinMillisecondsWhenTheTwinDies) {
  ASSERT_EQ(state(0), AxisState::tracking);
  rehearsal_.kill_twin();
  rehearsal_.run_for(milliseconds(4));
  EXPECT_EQ(state(0), AxisState::faulted);
  EXPECT_EQ(cause(0), Cause::commands_late) << "no node is left to acknowledge them";
  EXPECT_EQ(state(1), AxisState::faulted);
}

TEST_F(TrackingLoop, AllocatesNothing) {
  ASSERT_EQ(state(0), AxisState::tracking);
  const std::uint64_t before = support::allocations_so_far();
  rehearsal_.run_for(std::chrono::seconds(1));
  const std::uint64_t after = support::allocations_so_far();
  EXPECT_EQ(after, before) << "controller, twin and simulated bus, a thousand cycles of two axes";
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

TEST_F(TrackingLoop, StopsAtTheSafeValue) {
  ASSERT_EQ(state(0), AxisState::tracking);
  ASSERT_GT(stage(0).plant.drive(), 1.0);
  rehearsal_.controller().request_stop();
  rehearsal_.run_for(milliseconds(500));
  EXPECT_TRUE(rehearsal_.controller().stopped());
  for (const std::size_t axis : {0u, 1u}) {
    EXPECT_EQ(state(axis), AxisState::offline);
    EXPECT_EQ(stage(axis).amplifier.state(), can::AmpState::ready);
    EXPECT_NEAR(stage(axis).plant.drive(), 0.0, 1e-6);
  }
}

TEST_F(TrackingLoop, FaultsWhenANodeRestarts) {
  ASSERT_EQ(state(0), AxisState::tracking);
  twin::FaultSpec reboot = twin::fault_spec(twin::Fault::node_reboot, "x");
  rehearsal_.twin().faults().inject(reboot);
  rehearsal_.twin().faults().remove(reboot.kind);
  rehearsal_.run_for(milliseconds(10));
  EXPECT_EQ(cause(0), Cause::node_restarted);
  EXPECT_EQ(state(1), AxisState::tracking) << "no node of the other axis restarts";
  EXPECT_EQ(stage(0).amplifier.state(), can::AmpState::ready);
}

TEST_F(TrackingLoop, RejectsForeignAndDamagedFramesWithTheIdentifierOfTheSample) {
  ASSERT_EQ(state(0), AxisState::tracking);
  const auto tester = rehearsal_.attach()({});
  for (int i = 0; i < 200; ++i) {
    can::Frame frame{.id = 0x182, .length = 8};
    frame.data[0] = static_cast<std::uint8_t>(i);
    frame.extended = i % 4 == 1;
    if (i % 4 == 2) frame.length = 5;
    if (i % 4 == 3) frame.kind = can::FrameKind::remote;
    tester->send(frame);
    rehearsal_.run_for(milliseconds(1));
  }
  EXPECT_EQ(state(0), AxisState::tracking);
  const can::E2eChecker& checker = rehearsal_.controller().sample_checker(0);
  for (const can::Rejection cause : {can::Rejection::wrong_crc, can::Rejection::extended_id,
                                     can::Rejection::wrong_length, can::Rejection::wrong_kind})
    EXPECT_EQ(checker.rejected(cause), 50u) << to_string(cause);
}

}  // namespace
}  // namespace hystcan::closed_loop_test
