// The whole closed loop in virtual time: frames are encoded and decoded in both directions, with the
// simulated bus in between.
//
//   bench_loop [CONFIG]     prints the time of an axis-cycle and that of the model alone in the same run;
//                           then the cost of learning, and the cost of an axis among 32
//   bench_loop --scale      prints docs/evidence/scale.csv: 1 to 64 axes on 1 to 4 interfaces, with a process
//                           for each interface
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

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

/// Each axis has two nodes, and the largest node number is 127.
constexpr std::size_t most_axes = 63;

/// Returns the processor time, which other programs hardly disturb.
double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Returns the best repetition of each run. The runs alternate, so that a disturbance affects all of them.
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
  loop.run_for(2s);  // the axes track after this time
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

/// The baseline is the arithmetic of a cycle without frames and bus: one inverse and its advance for the
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

/// Returns the nanoseconds of a cycle that looks up its reference and, if `learning` is not null, learns.
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
    controller::Trajectory::Point ahead = now;  // like ClosedLoop
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

/// The cost of a process with this number of axes.
struct Cost {
  double start_ms = 0.0;       ///< time to read the configuration and to make controller, twin and simulated
                               ///< bus
  double axis_cycle_ns = 0.0;  ///< time of the whole loop, including the twin's share
  double resident_kB = 0.0;    ///< maximum over the processes
};

Cost cost_of(std::size_t axes) {
  Cost cost{.start_ms = std::numeric_limits<double>::infinity()};
  for (int i = 0; i < repetitions; ++i) {
    const double start_s = processor_s();
    const rehearsal::Setup setup =
        support::many_axes(config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml"), axes);
    const rehearsal::Rehearsal loop(setup, [](const controller::CycleRecord&) {});
    cost.start_ms = std::min(cost.start_ms, 1e3 * (processor_s() - start_s));
  }
  const rehearsal::Setup setup =
      support::many_axes(config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml"), axes);
  cost.axis_cycle_ns = 1e9 / best_of_each([&] { return loop_cycles_per_s(setup); })[0];
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  cost.resident_kB = static_cast<double>(usage.ru_maxrss);
  return cost;
}

/// Returns the costs in simultaneous processes, one for each interface.
std::vector<Cost> costs_of(std::size_t interfaces, std::size_t axes) {
  std::vector<int> pipes;
  for (std::size_t i = 0; i < interfaces; ++i) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    if (fork() == 0) {
      const Cost cost = cost_of(axes / interfaces);
      _exit(write(ends[1], &cost, sizeof cost) == sizeof cost ? 0 : 1);
    }
    close(ends[1]);
    pipes.push_back(ends[0]);
  }
  std::vector<Cost> costs(interfaces);
  for (std::size_t i = 0; i < interfaces; ++i) {
    if (read(pipes[i], &costs[i], sizeof costs[i]) != sizeof costs[i])
      throw std::runtime_error("a process has failed");
    close(pipes[i]);
    wait(nullptr);
  }
  return costs;
}

void write_scale() {
  std::printf("interfaces,axes,axes_per_process,start_ms,axis_cycle_ns,resident_kB_of_all\n");
  for (const std::size_t interfaces : {1U, 2U, 4U})
    for (std::size_t axes = interfaces; axes <= 64; axes *= 2) {
      const std::size_t each = std::min(axes / interfaces, most_axes);
      Cost sum{};
      for (const Cost& cost : costs_of(interfaces, each * interfaces)) {
        sum.start_ms = std::max(sum.start_ms, cost.start_ms);
        sum.axis_cycle_ns += cost.axis_cycle_ns / static_cast<double>(interfaces);
        sum.resident_kB += cost.resident_kB;
      }
      std::printf("%zu,%zu,%zu,%.1f,%.0f,%.0f\n", interfaces, each * interfaces, each, sum.start_ms,
                  sum.axis_cycle_ns, sum.resident_kB);
      std::fflush(stdout);
    }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "--scale") {
    write_scale();
    return 0;
  }
  bench::Budgets budgets("bench_loop");
  const std::string file = argc > 1 ? argv[1] : HYSTCAN_SOURCE_DIR "/config/piezo.toml";
  const config::Config config = config::load(file);
  const rehearsal::Setup setup = support::setup_of(config);
  const auto [loop, model] =
      best_of_each([&] { return loop_cycles_per_s(setup); }, [&] { return model_cycles_per_s(setup); });
  budgets.print_heading();
  budgets.ratio("whole loop / model alone (inverse, two advances)", model / loop, {14.0, 18.3});
  budgets.print("whole loop in virtual time, ns an axis-cycle", 1e9 / loop, {2000.0});
  budgets.print("model alone, ns", 1e9 / model);
  print_cost_of_learning(budgets, setup);
  print_cost_of_many_axes(budgets, config);
  return budgets.status();
}
