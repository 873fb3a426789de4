// The time of an axis-cycle with 1 to 32 axes in one process: it must not grow with their number.
//
//   bench_axes        prints ns per axis-cycle, and the ratio to a single axis
//
//   whole loop        controller, twin and simulated bus, which has two nodes for each axis
//   controller alone  the controller without a bus: it gets samples, statuses and heartbeats that are encoded
//                     beforehand, and its own frames go nowhere

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "can/sim/sim_bus.h"
#include "config/schema/config.h"
#include "controller/controller.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/many_axes.h"
#include "tests/bench/short_run.h"

namespace {

using namespace hystcan;

const int repetitions = bench::full_or_short(5, 1);
constexpr double budget_ratio = 1.2;

/// The best of some repetitions: the speed without disturbance by other programs.
template <class Run>
double best_of(Run run) {
  double least = run();
  for (int i = 1; i < repetitions; ++i) least = std::min(least, run());
  return least;
}

double whole_loop_ns(const rehearsal::Setup& setup) {
  const std::size_t axes = setup.controller.axes.size();
  rehearsal::Rehearsal loop(setup, [](const controller::CycleRecord&) {});
  loop.start();
  loop.run_for(std::chrono::seconds(3));
  const controller::Axis& last_axis = loop.controller().axis(axes - 1);
  if (last_axis.state() != controller::AxisState::tracking)
    throw std::runtime_error("the whole loop does not track: " +
                             std::string(to_string(last_axis.fault().cause)));
  const auto cycles_before = loop.controller().counters().cycles;
  const double start_s = bench::cpu_s();
  loop.run_for(std::chrono::milliseconds(8000 / axes));
  const double elapsed_s = bench::cpu_s() - start_s;
  return 1e9 * elapsed_s / static_cast<double>((loop.controller().counters().cycles - cycles_before) * axes);
}

constexpr int status_every = 10;  ///< cycles
constexpr double um_per_V = 0.3;  ///< of a stage that follows at once

/// Counts the frames that are sent and drops them; gives the owner only the frames of deliver().
class DeafBus final : public can::Bus {
 public:
  bool send(const can::Frame&) override {
    ++counters_.sent;
    return true;
  }
  void on_frame(FrameHandler handler) override { handler_ = std::move(handler); }
  bool on_sent(FrameHandler) override { return false; }
  void on_state(StateHandler) override {}
  can::BusState state() const override { return can::BusState::active; }
  const can::BusCounters& counters() const override { return counters_; }
  void deliver(const can::Frame& frame, can::Time now) { handler_(frame, now); }

 private:
  FrameHandler handler_;
  can::BusCounters counters_;
};

/// The frames that the controller receives from both nodes of each axis.
class Nodes {
 public:
  explicit Nodes(const rehearsal::Setup& setup) {
    axes_.reserve(setup.controller.axes.size());
    for (const auto& axis : setup.controller.axes)
      axes_.push_back({.sample = can::Encoder<can::SensorSample>(
                           *can::find_layout<can::SensorSample>(setup.database, axis.wire)),
                       .status = can::Encoder<can::AmpStatus>(
                           *can::find_layout<can::AmpStatus>(setup.database, axis.wire)),
                       .wire = axis.wire});
  }
  /// Appends the frames of one cycle. Statuses come in every tenth cycle, heartbeats in every hundredth.
  void append(std::uint64_t cycle, const controller::Controller& loop, std::vector<can::Frame>& frames) {
    const auto counter = static_cast<std::uint8_t>(cycle % can::sync_counter_max + 1);
    for (std::size_t i = 0; i < axes_.size(); ++i)
      frames.push_back(
          *axes_[i].sample({.position_um = um_per_V * loop.axis(i).report().drive, .sync_counter = counter}));
    if (cycle % status_every == 0)
      for (std::size_t i = 0; i < axes_.size(); ++i)
        frames.push_back(
            *axes_[i].status({.output = loop.axis(i).report().drive, .state = can::AmpState::enabled}));
    if (cycle % 100 == 0)
      for (const Axis& axis : axes_)
        for (const std::uint8_t node : {axis.wire.amplifier_node, axis.wire.sensor_node})
          frames.push_back(can::heartbeat_frame(node, can::NmtState::operational));
  }

 private:
  struct Axis {
    can::Encoder<can::SensorSample> sample;
    can::Encoder<can::AmpStatus> status;
    can::AxisWire wire;
  };
  std::vector<Axis> axes_;
};

double controller_ns(rehearsal::Setup setup) {
  const std::size_t axes = setup.controller.axes.size();
  for (auto& axis :
       setup.controller.axes) {  // the frames are made for some cycles at once: the stage is late
    axis.axis.following_error.error_um = 1e9;
    axis.axis.supervision.frozen_cycles = 0;
    axis.axis.supervision.saturated_s = 0.0;
    axis.axis.supervision.position_jump_um = 1e9;
    axis.axis.law.pi.ki_per_s = 1.0;
  }
  can::VirtualClock clock;
  DeafBus* bus = nullptr;
  controller::Controller loop(
      setup.controller, setup.database, clock,
      [&](std::span<const can::Filter>) {
        auto made = std::make_unique<DeafBus>();
        bus = made.get();
        return made;
      },
      [](const controller::CycleRecord&) {});
  Nodes nodes(setup);
  loop.start();
  clock.run_until(can::Time{} + setup.controller.heartbeat_period);  // the first SYNC
  constexpr auto period = std::chrono::milliseconds(1);
  constexpr int block = status_every;  // a status reports the drive at its beginning
  std::vector<std::vector<can::Frame>> frames(block);
  std::uint64_t cycle = 0;
  double timed_s = 0.0;
  std::uint64_t timed_cycles = 0;
  const std::uint64_t warm_up = 3000, last = warm_up + 60'000 / axes;
  while (cycle < last) {
    for (int i = 0; i < block; ++i) {
      frames[static_cast<std::size_t>(i)].clear();
      nodes.append(cycle++, loop, frames[static_cast<std::size_t>(i)]);
    }
    const double start_s = bench::cpu_s();
    for (const std::vector<can::Frame>& of_cycle : frames) {
      for (const can::Frame& frame : of_cycle) bus->deliver(frame, clock.now());
      clock.run_until(clock.now() + period);
    }
    if (cycle < warm_up) continue;
    timed_s += bench::cpu_s() - start_s;
    timed_cycles += block;
  }
  const controller::Axis& last_axis = loop.axis(axes - 1);
  if (last_axis.state() != controller::AxisState::tracking || loop.counters().missing_samples != 0)
    throw std::runtime_error("the controller alone does not track: " +
                             std::string(to_string(last_axis.fault().cause)));
  return 1e9 * timed_s / static_cast<double>(timed_cycles * axes);
}

}  // namespace

int main() {
  bench::announce_short_run();
  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  std::printf("ns per axis-cycle, best of %d, and the ratio to one axis\n", repetitions);
  std::printf("axes   whole loop            controller alone\n");
  double whole_of_one = 0.0, controller_of_one = 0.0, ratio = 0.0;
  for (const std::size_t axes : {1u, 2u, 4u, 8u, 16u, 32u}) {
    const rehearsal::Setup setup = bench::many_axes(config, axes);
    const double whole = best_of([&] { return whole_loop_ns(setup); });
    const double alone = best_of([&] { return controller_ns(setup); });
    if (axes == 1) whole_of_one = whole, controller_of_one = alone;
    ratio = alone / controller_of_one;
    std::printf("%4zu   %8.0f  x %-8.2f   %8.0f  x %.2f\n", axes, whole, whole / whole_of_one, alone, ratio);
  }
  std::printf("controller alone, 32 axes to one: %.2f; budget %.2f: %s\n", ratio, budget_ratio,
              bench::verdict(ratio <= budget_ratio));
}
