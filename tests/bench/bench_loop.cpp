// The whole closed loop in virtual time: frames encoded and decoded both ways, the simulated bus in between.
//
//   bench_loop [CONFIG]     prints the time of an axis-cycle, beside that of the model alone in the same run;
//                           then the cost of learning, and that of an axis among 32
#include <time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>
#include <string>

#include "config/schema/config.h"
#include "controller/analysis/learning_design.h"
#include "model/hysteresis.h"
#include "rehearsal/rehearsal.h"
#include "tests/bench/budgets.h"
#include "tests/bench/short_run.h"
#include "tests/support/many_axes.h"
#include "tests/support/rehearsed.h"

namespace {

using namespace hystcan;
using namespace std::chrono_literals;

const int repetitions = bench::full_or_short(9, 5);
const std::chrono::seconds timed = bench::full_or_short(10s, 2s);

/// Processor time: other programs disturb it little.
double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The best of some repetitions of each run, in turns: a disturbance affects all of them.
template <class... Run>
std::array<double, sizeof...(Run)> best_of_each(const Run&... runs) {
  std::array<double, sizeof...(Run)> best{};
  for (int i = 0; i < repetitions; ++i) {
    std::size_t at = 0;
    for (const double figure : {runs()...}) best[at] = std::max(best[at], figure), ++at;
  }
  return best;
}

double loop_cycles_per_s(const rehearsal::Setup& setup) {
  rehearsal::Rehearsal loop(setup, [](const controller::CycleRecord&) {});
  loop.start();
  loop.run_for(2s);  // the axes track by now
  const auto cycles_before = loop.controller().counters().cycles;
  const double start_s = processor_s();
  loop.run_for(timed);
  const double elapsed_s = processor_s() - start_s;
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
  const double start_s = processor_s();
  for (int i = 0; i < cycles; ++i) {
    const double drive = model.inverse(controller, value_um(triangle, 1e-3 * i)).value;
    model.advance(controller, drive);
    model.advance(plant, drive);
  }
  return cycles / (processor_s() - start_s);
}

/// Nanoseconds of a cycle that looks its reference up, and that learns where `learning` is not null.
double reference_ns(const controller::Trajectory& trajectory, controller::Learning* learning) {
  constexpr int cycles = 200'000;
  constexpr double cycle_s = 1e-3;
  double sum = 0.0;
  const double start_s = processor_s();
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
  const double elapsed_s = processor_s() - start_s;
  return sum == 0.0 ? 0.0 : 1e9 * elapsed_s / cycles;
}

void print_cost_of_learning(bench::Budgets& budgets, rehearsal::Setup setup) {
  controller::AxisConfig& axis = setup.controller.axes[0].axis;
  axis.setpoint = {
      {.shape = controller::Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 10.0, .cycles = 1e5}}};
  axis.learning = {.correction_max_um = 1.0};
  controller::plan_learning(axis, setup.controller.rate_Hz);
  const controller::Trajectory trajectory = controller::reference_of(axis);
  controller::Learning learning(*axis.learning);
  const auto [without, with] = best_of_each([&] { return 1e9 / reference_ns(trajectory, nullptr); },
                                            [&] { return 1e9 / reference_ns(trajectory, &learning); });
  budgets.print("learning and its look-up of the reference, ns a cycle", 1e9 / with - 1e9 / without, {60.0});
}

/// The time of an axis-cycle must not grow with the number of axes.
void print_cost_of_many_axes(bench::Budgets& budgets, const config::Config& config) {
  const auto cycles_per_s = [&](std::size_t axes) {
    return [&config, axes] { return loop_cycles_per_s(support::many_axes(config, axes)); };
  };
  const auto [one, many] = best_of_each(cycles_per_s(1), cycles_per_s(32));
  budgets.ratio("an axis-cycle with 32 axes / with one", one / many, {1.15});
}

}  // namespace

int main(int argc, char** argv) {
  bench::Budgets budgets("bench_loop");
  const std::string file = argc > 1 ? argv[1] : HYSTCAN_SOURCE_DIR "/config/piezo.toml";
  const config::Config config = config::load(file);
  const rehearsal::Setup setup = support::setup_of(config);
  const auto [loop, model] =
      best_of_each([&] { return loop_cycles_per_s(setup); }, [&] { return model_cycles_per_s(setup); });
  budgets.print_heading();
  budgets.ratio("whole loop / model alone (inverse, two advances)", model / loop, {14.0});
  budgets.print("whole loop in virtual time, ns an axis-cycle", 1e9 / loop, {2000.0});
  budgets.print("model alone, ns", 1e9 / model);
  print_cost_of_learning(budgets, setup);
  print_cost_of_many_axes(budgets, config);
  return budgets.status();
}
