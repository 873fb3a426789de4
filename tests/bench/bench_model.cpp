// Nanoseconds per step of the hysteresis model beside their budgets (docs/theory.md): order 10, memory depth
// 1 to 1000, and a Prandtl-Ishlinskii model of 30 play operators, the usual alternative, in the same run.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "model/hysteresis.h"

namespace {

using namespace hystcan::model;

Hysteresis tenth_order() {
  const Interval range{0.0, 3.0};
  std::vector<double> ascending{0.0, 4.0, 14.0, -6.0, 0.9, 0.01, -0.004, 0.0002, 1e-5, -2e-6, 1e-7};
  std::vector<double> descending = ascending;
  descending[0] += 0.24;
  descending[1] += 0.32;
  descending[2] -= 1.2 / 9.0;
  return Hysteresis({"A", "um", ReferenceCurve(Basis::power, ascending, range),
                     ReferenceCurve(Basis::power, descending, range), 1.0, 1.2, Symmetry::none});
}

// Nested turning points around 1.5 A, and 1024 steps inside the innermost loop's next branch: no target is
// passed.
struct Course {
  Hysteresis model = tenth_order();
  HysteresisState state = model.at_lower_threshold(1100);
  std::vector<double> inputs, outputs;

  explicit Course(std::size_t depth) {
    for (std::size_t i = 0; state.depth() < depth; ++i) {
      const double half = 1.4 * (1.0 - 0.9 * static_cast<double>(i) / static_cast<double>(depth));
      model.advance(state, 1.5 + (i % 2 == 0 ? half : -half));
    }
    const double from = state.input;
    const double to = depth == 1 ? 1.5 : from + 0.9 * (state.branches.back().start_input - from);
    for (int i = 1; i <= 1024; ++i) inputs.push_back(from + (to - from) * i / 1100.0);
    for (const double v : inputs) outputs.push_back(model.forward(state, v).value);
  }
};

void forward_look(benchmark::State& run) {
  const Course course(static_cast<std::size_t>(run.range(0)));
  while (run.KeepRunningBatch(static_cast<benchmark::IterationCount>(course.inputs.size())))
    for (const double v : course.inputs)
      benchmark::DoNotOptimize(course.model.forward(course.state, v).value);
}

void forward_step(benchmark::State& run) {
  Course course(static_cast<std::size_t>(run.range(0)));
  course.model.advance(course.state, course.inputs.front());
  const HysteresisState start = course.state;
  HysteresisState state = start;
  while (run.KeepRunningBatch(static_cast<benchmark::IterationCount>(course.inputs.size()))) {
    state = start;
    for (const double v : course.inputs) benchmark::DoNotOptimize(course.model.advance(state, v).value);
  }
}

void inverse_step(benchmark::State& run) {
  Course course(static_cast<std::size_t>(run.range(0)));
  course.model.advance(course.state, course.inputs.front());
  const HysteresisState start = course.state;
  HysteresisState state = start;
  while (run.KeepRunningBatch(static_cast<benchmark::IterationCount>(course.inputs.size()))) {
    state = start;
    for (const double x : course.outputs) {
      const double v = course.model.inverse(state, x).value;
      course.model.advance(state, v);
      benchmark::DoNotOptimize(v);
    }
  }
}

void forward_reversals(benchmark::State& run) {
  Course course(100);
  HysteresisState state = course.state;
  const double at = state.input, other = at + 0.5 * (state.branches.back().start_input - at);
  course.model.advance(state, at + 0.6 * (state.branches.back().start_input - at));
  for (auto _ : run) {
    benchmark::DoNotOptimize(course.model.advance(state, at + 0.01 * (other - at)).value);
    benchmark::DoNotOptimize(course.model.advance(state, other).value);
  }
  run.SetItemsProcessed(2 * run.iterations());
}

void prandtl_ishlinskii_30(benchmark::State& run) {
  const Course course(1);
  double threshold[30], weight[30], play[30] = {};
  for (int i = 0; i < 30; ++i) threshold[i] = 0.05 * i, weight[i] = 1.0 / (1.0 + i);
  while (run.KeepRunningBatch(static_cast<benchmark::IterationCount>(course.inputs.size()))) {
    for (const double v : course.inputs) {
      double sum = 0.0;
      for (int i = 0; i < 30; ++i) {
        play[i] = std::max(v - threshold[i], std::min(v + threshold[i], play[i]));
        sum += weight[i] * play[i];
      }
      benchmark::DoNotOptimize(sum);
    }
  }
}

void construction(benchmark::State& run) {
  for (auto _ : run) benchmark::DoNotOptimize(tenth_order());
}

BENCHMARK(forward_look)->Arg(1)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK(forward_step)->Arg(1)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK(inverse_step)->Arg(1)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK(forward_reversals);
BENCHMARK(prandtl_ishlinskii_30);
BENCHMARK(construction)->Unit(benchmark::kMillisecond);

/// Prints as usual, and keeps the best of the repetitions: what the machine can do when it is left alone.
class Reporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.error_occurred || run.run_type != Run::RT_Iteration) continue;
      const double ns = 1e9 * run.cpu_accumulated_time / static_cast<double>(run.iterations);
      const auto [place, is_new] = ns_.try_emplace(run.run_name.function_name + "/" + run.run_name.args, ns);
      if (!is_new) place->second = std::min(place->second, ns);
    }
  }

  void compare() const {
    line("forward step, depth 1, ns", ns("forward_step/1"), 10.0);
    line("forward step, depth 1000, ns", ns("forward_step/1000"), 10.0);
    line("forward step, depth 1000 / depth 1", ns("forward_step/1000") / ns("forward_step/1"), 1.2);
    line("forward step / 30 play operators", ns("forward_step/100") / ns("prandtl_ishlinskii_30/"), 1.0);
    line("inverse step, depth 100, with its advance, ns", ns("inverse_step/100"), 80.0);
  }

 private:
  double ns(const std::string& name) const { return ns_.contains(name) ? ns_.at(name) : std::nan(""); }
  static void line(const char* what, double value, double budget) {
    std::printf("%-48s %8.2f  budget %6.2f  %s\n", what, value, budget,
                std::isnan(value) ? "not run" : (value <= budget ? "met" : "missed"));
  }

  std::map<std::string, double> ns_;
};

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  Reporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.compare();
}
