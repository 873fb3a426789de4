// The whole closed loop in virtual time: frames encoded and decoded both ways, the simulated bus in between.
//
//   bench_loop        prints axis-cycles per second beside the budget, and beside the model alone in the
//                     same run; then the cost of learning, and that of an axis among 32
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "config/schema/config.h"
#include "controller/analysis/learning_design.h"
#include "model/hysteresis.h"
#include "rehearsal/rehearsal.h"
#include "tests/bench/short_run.h"
#include "tests/support/many_axes.h"
#include "tests/support/rehearsed.h"

namespace {

using namespace hystcan;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

const int repetitions = bench::full_or_short(7, 1);
const std::chrono::seconds timed = bench::full_or_short(10s, 1s);
constexpr double budget_per_s = 500'000.0;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The best of some repetitions: the speed without disturbance by other programs.
template <class Run>
double best_of(Run run) {
  double best = 0.0;
  for (int i = 0; i < repetitions; ++i) best = std::max(best, run());
  return best;
}

double loop_cycles_per_s(const rehearsal::Setup& setup) {
  rehearsal::Rehearsal loop(setup, [](const controller::CycleRecord&) {});
  loop.start();
  loop.run_for(2s);  // the axes track by now
  const auto cycles_before = loop.controller().counters().cycles;
  const auto start = Clock::now();
  loop.run_for(timed);
  const double elapsed_s = seconds_since(start);
  for (std::size_t i = 0; i < setup.controller.axes.size(); ++i)
    if (loop.controller().axis(i).state() == controller::AxisState::faulted)
      throw std::runtime_error("an axis has a fault: " +
                               std::string(to_string(loop.controller().axis(i).fault().cause)));
  return static_cast<double>((loop.controller().counters().cycles - cycles_before) *
                             setup.controller.axes.size()) /
         elapsed_s;
}

/// The baseline is the mathematics of a cycle without frames and bus: one inverse and its advance for the
/// controller, one advance for the plant.
double model_cycles_per_s(const rehearsal::Setup& setup) {
  const model::Hysteresis model(setup.controller.axes.front().axis.law.model);
  model::HysteresisState controller = model.at_lower_threshold();
  model::HysteresisState plant = model.at_lower_threshold();
  const controller::Shape triangle =
      controller::Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 10.0, .cycles = 1e6};
  constexpr int cycles = 200'000;
  const auto start = Clock::now();
  for (int i = 0; i < cycles; ++i) {
    const double drive = model.inverse(controller, value_um(triangle, 1e-3 * i)).value;
    model.advance(controller, drive);
    model.advance(plant, drive);
  }
  return cycles / seconds_since(start);
}

/// Nanoseconds of a cycle that looks its reference up, and that learns where `learning` is not null.
double reference_ns(const controller::Trajectory& trajectory, controller::Learning* learning) {
  constexpr int cycles = 200'000;
  constexpr double cycle_s = 1e-3;
  double sum = 0.0;
  const auto start = Clock::now();
  for (int i = 0; i < cycles; ++i) {
    const controller::Trajectory::Point now = trajectory.at(1.0 + cycle_s * i);
    sum += now.value_um;
    if (learning == nullptr) continue;
    learning->learn(now, 1e-4 * now.value_um, true);
    controller::Trajectory::Point ahead = now;  // as ClosedLoop does
    ahead.shape_time_s += 2.0 * cycle_s;
    if (!learning->covers(ahead)) ahead = trajectory.at(1.0 + cycle_s * (i + 2));
    sum += learning->correct(now, ahead, cycle_s).ahead_um;
  }
  const double elapsed_s = seconds_since(start);
  return sum == 0.0 ? 0.0 : 1e9 * elapsed_s / cycles;
}

void print_cost_of_learning(rehearsal::Setup setup) {
  constexpr double budget_ns = 60.0;
  controller::AxisConfig& axis = setup.controller.axes[0].axis;
  axis.setpoint = {
      {.shape = controller::Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 10.0, .cycles = 1e5}}};
  axis.learning = {.correction_max_um = 1.0};
  controller::plan_learning(axis, setup.controller.rate_Hz);
  const controller::Trajectory trajectory = controller::reference_of(axis);
  controller::Learning learning(*axis.learning);
  const double without = 1e9 / best_of([&] { return 1e9 / reference_ns(trajectory, nullptr); });
  const double with = 1e9 / best_of([&] { return 1e9 / reference_ns(trajectory, &learning); });
  std::printf("learning: %.0f ns a cycle, its look-up of the reference included; budget %.0f: %s\n",
              with - without, budget_ns, bench::verdict(with - without <= budget_ns));
}

/// The time of an axis-cycle must not grow with the number of axes.
void print_cost_of_many_axes(const config::Config& config) {
  constexpr double budget = 1.15;
  const auto cycles_per_s = [&](std::size_t axes) {
    return best_of([&] { return loop_cycles_per_s(support::many_axes(config, axes)); });
  };
  const double ratio = cycles_per_s(1) / cycles_per_s(32);
  std::printf("an axis-cycle with 32 axes / with one: %.2f; budget %.2f: %s\n", ratio, budget,
              bench::verdict(ratio <= budget));
}

}  // namespace

int main(int argc, char** argv) {
  bench::announce_short_run();
  const std::string file = argc > 1 ? argv[1] : HYSTCAN_SOURCE_DIR "/config/piezo.toml";
  const config::Config config = config::load(file);
  const rehearsal::Setup setup = support::setup_of(config);
  const double loop = best_of([&] { return loop_cycles_per_s(setup); });
  const double model = best_of([&] { return model_cycles_per_s(setup); });
  std::printf("whole loop in virtual time, %zu axes: %.0f axis-cycles/s, %.0f ns each; budget %.0f: %s\n",
              config.axes.size(), loop, 1e9 / loop, budget_per_s, bench::verdict(loop >= budget_per_s));
  std::printf(
      "model alone (inverse, two advances):  %.0f cycles/s, %.0f ns each; the loop costs %.1f times that\n",
      model, 1e9 / model, model / loop);
  print_cost_of_learning(setup);
  print_cost_of_many_axes(config);
}
