// Sub-steps are on a fixed grid: the motion of a plant depends only on its commands and their times.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <vector>

#include "tests/twin/stage.h"

namespace hystcan::twin::grid_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

struct Command {
  can::Time time;
  double drive;
  bool moves;  ///< the target, within a millisecond; cut short, completed, or followed by a rest
};

/// A plant with all options, with the hysteresis of the piezo stage or with its butterfly.
Plant::Config complete_stage(bool even) {
  Plant::Config config = piezo_stage();
  model::HysteresisParameters parameters = support::piezo_model();
  if (even) parameters.symmetry = model::Symmetry::even;
  config.hysteresis = parameters;
  config.amplifier.drive_min = -120.0;
  config.second_mode = SecondMode{{.natural_frequency_Hz = 1170.0, .damping_ratio = 0.01}, 0.2};
  config.creep = LogarithmicCreep{.per_decade = 0.015, .from_s = 0.01, .to_s = 1.0};
  config.temperature =
      Temperature{.swing_K = 2.0, .period_s = 0.3, .expansion_um_per_K = 0.1, .gain_per_K = 1e-3};
  return config;
}

double own_noise(can::Time time) { return 0.01 * std::sin(1e4 * can::seconds(time.time_since_epoch())); }

std::vector<Command> any_commands() {
  std::vector<Command> commands;
  can::Time now{};
  for (const auto& [pause_ns, drive_mV, moves] :
       *rc::gen::container<std::vector<std::tuple<int, int, bool>>>(rc::gen::tuple(
           rc::gen::inRange(1, 3'000'000), rc::gen::inRange(-120'000, 120'000), rc::gen::arbitrary<bool>())))
    commands.push_back({now += can::Duration{pause_ns}, 1e-3 * drive_mV, moves});
  return commands;
}

/// Returns the position at each command and 5 ms after the last one.
template <class Look>
std::vector<double> positions(const Plant::Config& config, const std::vector<Command>& commands, bool noisy,
                              Look look) {
  Plant plant(config, can::Time{});
  if (noisy) plant.set_drive_noise(own_noise);
  std::vector<double> all;
  can::Time now{};
  const auto go_on = [&](can::Time to) {
    look(plant, now, to);
    plant.advance_to(now = to);
    all.push_back(plant.position_um());
  };
  for (const Command& command : commands) {
    go_on(command.time);
    command.moves ? plant.move_target(command.drive, milliseconds(1)) : plant.set_target(command.drive);
  }
  go_on(now + milliseconds(5));
  return all;
}

// Equality to the bit; 1e-9 um would be sufficient.
TEST(Plant, IsNotChangedByReading) {
  EXPECT_TRUE(rc::check("looks", [] {
    const bool even = *rc::gen::arbitrary<bool>(), noisy = *rc::gen::arbitrary<bool>();
    const std::vector<Command> commands = any_commands();
    const auto pauses_ns = *rc::gen::nonEmpty<std::vector<int>>(
        rc::gen::container<std::vector<int>>(rc::gen::inRange(1, 400'000)));
    const auto never = [](Plant&, can::Time, can::Time) {};
    std::size_t next = 0;
    const auto often = [&](Plant& plant, can::Time now, can::Time to) {
      while ((now += can::Duration{pauses_ns[next++ % pauses_ns.size()]}) < to) plant.advance_to(now);
    };
    RC_ASSERT(positions(complete_stage(even), commands, noisy, never) ==
              positions(complete_stage(even), commands, noisy, often));
  }));
}

// A command that repeats the present target splits no sub-step and only reads the plant.
TEST(Plant, IgnoresARepeatedTarget) {
  Plant once(piezo_stage(), can::Time{}), again(piezo_stage(), can::Time{});
  once.set_target(50.0);
  again.set_target(50.0);
  for (int i = 1; i < 100; ++i) {
    again.advance_to(can::Time{} + microseconds(17 * i));
    again.set_target(50.0);
  }
  once.advance_to(can::Time{} + milliseconds(2));
  again.advance_to(can::Time{} + milliseconds(2));
  EXPECT_EQ(once.position_um(), again.position_um());
}

/// RMS difference of the position from that with a 64th of the sub-step, under 12 V steps every 1.01 ms.
double rms_error_um(int substep_ns) {
  const auto stage = [](int ns) {
    Plant::Config config = piezo_stage();
    config.substep = can::Duration{ns};
    return config;
  };
  Plant coarse(stage(substep_ns), can::Time{}), fine(stage(substep_ns / 64), can::Time{});
  double sum = 0.0;
  constexpr int cycles = 200;
  for (int i = 1; i <= cycles; ++i) {
    const double drive = 50.0 + 40.0 * std::sin(0.3 * i);
    coarse.set_target(drive);
    fine.set_target(drive);
    coarse.advance_to(can::Time{} + i * microseconds(1010));
    fine.advance_to(can::Time{} + i * microseconds(1010));
    sum += std::pow(coarse.position_um() - fine.position_um(), 2);
  }
  return std::sqrt(sum / cycles);
}

// Second order: half the sub-step gives a quarter of the error. The figures are in docs/theory/twin.md.
TEST(Plant, ConvergesToSecondOrderInTheSubstep) {
  const double at_50_us = rms_error_um(50'000), at_25_us = rms_error_um(25'000);
  RecordProperty("um_at_50_us", std::to_string(at_50_us));
  EXPECT_LT(at_50_us, 0.02);
  EXPECT_NEAR(at_50_us / at_25_us, 4.0, 0.6);
}

TEST(GridHandler, IsCalledAtEverySubstepWithThePositionThere) {
  Plant plant(piezo_stage(), can::Time{});
  Plant witness(piezo_stage(), can::Time{});
  std::vector<can::Time> times;
  std::vector<double> positions_um;
  plant.on_grid([&](can::Time time, double position_um) {
    times.push_back(time);
    positions_um.push_back(position_um);
  });
  plant.advance_to(can::Time{} + microseconds(10));
  plant.set_target(30.0);
  witness.advance_to(can::Time{} + microseconds(10));
  witness.set_target(30.0);
  for (const int us : {49, 50, 51, 230, 1000}) plant.advance_to(can::Time{} + microseconds(us));
  ASSERT_EQ(times.size(), 20u);
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_EQ(times[i], can::Time{} + (i + 1) * microseconds(50));
    witness.advance_to(times[i]);
    EXPECT_EQ(positions_um[i], witness.position_um());
  }
}

TEST(GridHandler, IsCalledOnceAtTheEndOfARest) {
  Plant plant(piezo_stage(), can::Time{});
  std::vector<can::Time> times;
  plant.on_grid([&](can::Time time, double) { times.push_back(time); });
  plant.advance_to(can::Time{} + std::chrono::hours(1) + microseconds(20));
  EXPECT_EQ(times, std::vector<can::Time>{can::Time{} + std::chrono::hours(1)});
}

TEST(DriveNoise, IsDrawnOncePerSubstepAndHeldOverIt) {
  Plant plant(linear_stage(), can::Time{});
  std::vector<can::Time> asked;
  plant.set_drive_noise([&](can::Time time) {
    asked.push_back(time);
    return 1.0 + static_cast<double>(asked.size());
  });
  plant.advance_to(can::Time{} + microseconds(30));
  EXPECT_EQ(plant.drive(), 0.0) << "the noise begins with the next sub-step";
  for (const int us : {50, 70, 99}) {
    plant.advance_to(can::Time{} + microseconds(us));
    EXPECT_EQ(plant.drive(), 2.0) << us;
    EXPECT_DOUBLE_EQ(plant.hysteresis_um(), 0.3 * 2.0) << us;
  }
  plant.advance_to(can::Time{} + microseconds(100));
  EXPECT_EQ(plant.drive(), 3.0);
  EXPECT_EQ(asked, (std::vector<can::Time>{can::Time{} + microseconds(50), can::Time{} + microseconds(100)}));
}

}  // namespace
}  // namespace hystcan::twin::grid_test
