// The twin alone: 8 axes at 4 kHz on a simulated bus of 16 Mbit/s, frames in and frames out.
//
//   bench_twin        prints how many times faster than real time it is on one core, beside the budget
//
// A tester sends SYNC and a command to each axis in every cycle, as a controller does, and reads the samples.
// As on a real bus, SYNCs do not come at the same place of the twin's grid of sub-steps: each is late by up
// to 10 us, with a resolution of a nanosecond.
//
//   shipped           axis x of the shipped piezo stage, eight times
//   everything        the same with a second mode, creep over five decades, temperature, drive noise, and
//                     a coupling to the axis before

#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <vector>

#include "can/sim/sim_bus.h"
#include "config/schema/config.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/many_axes.h"
#include "tests/bench/short_run.h"
#include "twin/twin.h"

namespace {

using namespace hystcan;

const int repetitions = bench::full_or_short(5, 1);
constexpr std::size_t axes = 8;
constexpr auto cycle = std::chrono::microseconds(250);
const int cycles = bench::full_or_short(8000, 800);
constexpr double budget = 1.0;

rehearsal::Setup with_everything(rehearsal::Setup setup) {
  for (std::size_t i = 0; i < axes; ++i) {
    twin::AxisConfig& axis = setup.twin.axes[i].axis;
    axis.plant.second_mode = twin::SecondMode{{.natural_frequency_Hz = 1170.0, .damping_ratio = 0.01}, 0.05};
    axis.plant.creep = twin::LogarithmicCreep{.per_decade = 0.015, .from_s = 0.01, .to_s = 1000.0};
    axis.plant.temperature =
        twin::Temperature{.swing_K = 1.0, .period_s = 600.0, .expansion_um_per_K = 0.1, .gain_per_K = 1e-3};
    const std::size_t before = (i + axes - 1) % axes;
    axis.couplings = {{.from = setup.twin.axes[before].wire.name, .um_per_um = 0.005, .index = before}};
  }
  return setup;
}

/// Adds white noise of one millivolt.
void add_noise(twin::Twin& twin) {
  std::uint64_t seed = 1;
  for (const auto& axis : twin.axes())
    axis->plant.set_drive_noise([random = boost::random::mt19937_64(seed++),
                                 normal = boost::random::normal_distribution<double>(0.0, 1e-3)](
                                    can::Time) mutable { return normal(random); });
}

/// Virtual seconds per second of processor time. Throws if samples are missing.
double speed(const rehearsal::Setup& setup, bool noisy) {
  can::VirtualClock clock;
  can::SimBus bus(clock, setup.rates);
  twin::Twin twin(setup.twin, setup.database, clock,
                  [&](auto) { return bus.attach(can::TransmitOrder::by_priority); });
  if (noisy) add_noise(twin);
  const std::unique_ptr<can::Bus> tester = bus.attach();
  std::size_t samples = 0;
  tester->on_frame([&](const can::Frame& frame, can::Time) {
    if (frame.id > 0x180 && frame.id < 0x200 && frame.id % 2 == 0) ++samples;
  });
  std::vector<can::Encoder<can::AmpCommand>> commands;
  commands.reserve(axes);
  for (const twin::WiredAxisConfig& axis : setup.twin.axes)
    commands.emplace_back(*can::find_layout<can::AmpCommand>(setup.database, axis.wire));
  boost::random::mt19937_64 random(1);
  boost::random::uniform_int_distribution<int> late_ns(0, 10'000);

  twin.start();
  clock.run_until(can::Time{} + setup.twin.heartbeat_period);
  tester->send(can::nmt_frame({can::NmtCommand::start, 0}));
  can::Time due = clock.now() + cycle;
  std::uint8_t counter = 0;
  const double start_s = bench::cpu_s();
  for (int i = 0; i < cycles; ++i, due += cycle) {
    clock.run_until(due + can::Duration{late_ns(random)});
    tester->send(can::sync_frame(counter = can::next_sync_counter(counter)));
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const double drive = 50.0 + 40.0 * std::sin(0.005 * i + static_cast<double>(axis));
      tester->send(*commands[axis]({.setpoint = drive, .enable = true, .sync_counter = counter}));
    }
  }
  clock.run_until(due);
  const double elapsed_s = bench::cpu_s() - start_s;
  const bool whole = samples == axes * static_cast<std::size_t>(cycles) &&
                     twin.axes().back()->amplifier.state() == can::AmpState::enabled;
  if (!whole) throw std::runtime_error("samples are missing, or an amplifier is not enabled");
  return cycles * can::seconds(cycle) / elapsed_s;
}

/// The best of some repetitions: the speed without disturbance by other programs.
void print(const char* name, const rehearsal::Setup& setup, bool noisy) {
  double best = 0.0;
  for (int i = 0; i < repetitions; ++i) best = std::max(best, speed(setup, noisy));
  std::printf("%-12s %6.1f times real time, %5.0f ns per axis-cycle; budget %.0f: %s\n", name, best,
              1e9 * can::seconds(cycle) / static_cast<double>(axes) / best, budget,
              bench::verdict(best >= budget));
}

}  // namespace

int main() {
  bench::announce_short_run();
  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  rehearsal::Setup shipped = bench::many_axes(config, axes);
  shipped.rates.nominal_bit_per_s = 16'000'000;  // 9 Mbit/s are needed, which no single bus has
  std::printf("the twin alone, %zu axes at %.0f Hz\n", axes, 1.0 / can::seconds(cycle));
  print("shipped", shipped, false);
  print("everything", with_everything(shipped), true);
}
