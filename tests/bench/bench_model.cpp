// Compares steps of the hysteresis model with their budgets (docs/theory/models.md), and with the usual
// models in the same run: play operators, Preisach relays, and the recursion as printed in the paper.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "model/hysteresis.h"
#include "model/output_creep.h"
#include "model/prandtl_ishlinskii.h"
#include "model/preisach.h"
#include "tests/bench/budgets.h"
#include "tests/bench/short_run.h"
#include "tests/support/relays.h"

namespace {

using namespace hystcan::model;

/// Reference curves on [0, 3], of third order as for a piezo stage, or of tenth order as for Galfenol.
HysteresisParameters curves(std::int64_t order) {
  const Interval range{0.0, 3.0};
  std::vector<double> ascending{0.0, 4.0, 14.0, -6.0, 0.9, 0.01, -0.004, 0.0002, 1e-5, -2e-6, 1e-7};
  if (order == 3) ascending = {0.0, 8.0, 0.6, 0.1};
  std::vector<double> descending = ascending;
  descending[0] += 0.24;
  descending[1] += 0.32;
  descending[2] -= 1.2 / 9.0;
  return {"A",
          "um",
          ReferenceCurve(Basis::power, ascending, range),
          ReferenceCurve(Basis::power, descending, range),
          1.0,
          1.2,
          Symmetry::none};
}

PrandtlIshlinskii plays(std::int64_t count) {
  PrandtlIshlinskiiParameters p{"A", "um", {0.0, 3.0}, 0.0, 6.0, {}, {}};
  for (std::int64_t i = 0; i < count; ++i) {
    p.thresholds.push_back(1.5 * static_cast<double>(i + 1) / static_cast<double>(count));
    p.weights.push_back(1.0 / static_cast<double>(i + 1));
  }
  return PrandtlIshlinskii(p);
}

PreisachParameters grid_of_100() {
  PreisachParameters p{"A", "um", {0.0, 3.0}, 0.0, 1.0, {}};
  p.weights.assign(5050, 30.0 / 5050);
  return p;
}

/// Adds turning points ever closer to 1.5 A until the memory contains `depth` branches.
template <class Model, class State>
void nest(const Model& model, State& state, std::int64_t depth) {
  for (std::int64_t i = 0; i < depth; ++i) {
    const double half = 1.4 * (1.0 - 0.9 * static_cast<double>(i) / static_cast<double>(depth));
    model.advance(state, 1.5 + (i % 2 == 0 ? half : -half));
  }
}

/// A sweep of 1024 steps from the present input that passes no turning point, as in a controller that tracks.
template <class Model>
struct Sweep {
  Model model;
  typename Model::State start;
  std::vector<double> inputs, outputs;

  Sweep(Model of, typename Model::State from, double to) : model(std::move(of)), start(std::move(from)) {
    for (int i = 1; i <= 1024; ++i) inputs.push_back(start.input + (to - start.input) * i / 1100.0);
    for (const double v : inputs) outputs.push_back(model.forward(start, v).value);
    model.advance(start, inputs.front());
  }
};

/// The curves of tenth order as splines of twelve pieces, narrower at one end.
HysteresisParameters splines() {
  HysteresisParameters p = curves(10);
  std::vector<double> knots;
  for (int i = 0; i <= 12; ++i) knots.push_back(3.0 * std::pow(i / 12.0, 1.5));
  for (ReferenceCurve* curve : {&p.ascending, &p.descending}) {
    std::vector<double> coefficients;
    for (const double v : greville_points(knots)) coefficients.push_back(curve->value(v));
    *curve = {CubicSpline(knots, coefficients), p.input_range()};
  }
  return p;
}

Sweep<Hysteresis> sweep_at(const HysteresisParameters& parameters, std::int64_t depth) {
  const Hysteresis model(parameters);
  HysteresisState state = model.at_lower_threshold(static_cast<std::size_t>(depth) + 4);
  if (depth > 1) nest(model, state, depth - 1);
  const double back = state.branches.back().start_input;
  return {model, state, depth == 1 ? 1.5 : state.input + 0.9 * (back - state.input)};
}

Sweep<Hysteresis> sweep_at(std::int64_t order, std::int64_t depth) { return sweep_at(curves(order), depth); }

Sweep<PrandtlIshlinskii> sweep_of_plays(std::int64_t count) {
  const PrandtlIshlinskii model = plays(count);
  PlayState state = model.virgin(0.0);
  nest(model, state, 9);
  return {model, state, 1.5};
}

template <class Model>
void forward(benchmark::State& run, const Sweep<Model>& sweep) {
  auto state = sweep.start;
  while (run.KeepRunningBatch(static_cast<benchmark::IterationCount>(sweep.inputs.size()))) {
    state = sweep.start;
    for (const double v : sweep.inputs) benchmark::DoNotOptimize(sweep.model.advance(state, v).value);
  }
}

/// Computes the inverse and advances the memory by its result.
template <class Model>
void inverse(benchmark::State& run, const Sweep<Model>& sweep) {
  auto state = sweep.start;
  while (run.KeepRunningBatch(static_cast<benchmark::IterationCount>(sweep.outputs.size()))) {
    state = sweep.start;
    for (const double x : sweep.outputs) {
      const auto found = sweep.model.inverse(state, x);
      sweep.model.advance(state, found);
      benchmark::DoNotOptimize(found.value);
    }
  }
}

/// Computes the inverse of the hysteresis and of the following creep, and advances both, as in the control
/// law.
void creep_inverse(benchmark::State& run) {
  const Sweep<Hysteresis> sweep = sweep_at(10, 100);
  const OutputCreep creep(OutputCreep::Config{.per_decade = 0.02});
  HysteresisState state = sweep.start;
  OutputCreep::State lags = creep.settled(state.output);
  while (run.KeepRunningBatch(static_cast<benchmark::IterationCount>(sweep.outputs.size()))) {
    state = sweep.start;
    creep.settle(lags, state.output);
    for (const double h : sweep.outputs) {
      const auto found = sweep.model.inverse(state, creep.inverse(lags, creep.output(lags, h)));
      creep.advance(lags, sweep.model.advance(state, found).value, 1e-3);
      benchmark::DoNotOptimize(found.value);
    }
  }
}

void forward_step(benchmark::State& run) { forward(run, sweep_at(run.range(0), run.range(1))); }
void inverse_step(benchmark::State& run) { inverse(run, sweep_at(run.range(0), run.range(1))); }
void spline_forward(benchmark::State& run) { forward(run, sweep_at(splines(), run.range(0))); }
void spline_inverse(benchmark::State& run) { inverse(run, sweep_at(splines(), run.range(0))); }
void plays_forward(benchmark::State& run) { forward(run, sweep_of_plays(run.range(0))); }
void plays_inverse(benchmark::State& run) { inverse(run, sweep_of_plays(run.range(0))); }

Sweep<Preisach> sweep_of_everett() {
  const Preisach model(grid_of_100());
  HysteresisState state = model.at_lower_threshold();
  nest(model, state, 9);
  return {model, state, 1.5};
}
void preisach_everett_forward(benchmark::State& run) { forward(run, sweep_of_everett()); }
void preisach_everett_inverse(benchmark::State& run) { inverse(run, sweep_of_everett()); }

void preisach_relays_forward(benchmark::State& run) {
  hystcan::support::Relays relays(grid_of_100());
  double v = 0.0;
  for (auto _ : run) {
    v = v < 2.0 ? v + 0.003 : 0.0;
    benchmark::DoNotOptimize(relays.advance(v));
  }
}

/// Computes only the necessary part of a step: the polynomial and the exponential, without memory or
/// decisions.
void bare_arithmetic(benchmark::State& run) {
  const Sweep<Hysteresis> sweep = sweep_at(run.range(0), 1);
  const ReferenceCurve& curve = sweep.model.parameters().ascending;
  const Branch branch = sweep.start.branches.back();
  const double k = sweep.model.parameters().k_ascending, reciprocal = 1.0 / k;
  while (run.KeepRunningBatch(static_cast<benchmark::IterationCount>(sweep.inputs.size())))
    for (const double v : sweep.inputs) {
      const double phi = (1.0 - std::exp(-k * std::abs(v - branch.start_input))) * reciprocal;
      benchmark::DoNotOptimize(curve.value(v) + (branch.offset - branch.coefficient * phi));
    }
}

/// Eq. (4) as printed, with the distances x_n - f_n(v_n) computed once at each reversal: a step is still
/// O(n).
class PrintedRecursion {
 public:
  PrintedRecursion(const HysteresisParameters& parameters, const HysteresisState& state) : p_(parameters) {
    for (std::size_t j = 0; j < state.depth(); ++j) {
      const Branch& b = state.branches[j];
      starts_.push_back(b.start_input);
      distances_.push_back(b.start_level - below(j, b.start_input));
    }
  }
  double output(double v) const { return branch(starts_.size() - 1, v); }

 private:
  bool rises(std::size_t j) const { return j % 2 == 0; }
  double branch(std::size_t j, double v) const {
    const double target = j > 0 ? starts_[j - 1] : 3.0;
    const double k = rises(j) ? p_.k_ascending : p_.k_descending;
    return below(j, v) + distances_[j] * std::expm1(k * std::abs(target - v)) /
                             std::expm1(k * std::abs(target - starts_[j]));
  }
  double below(std::size_t j, double v) const {
    return j >= 2 ? branch(j - 2, v) : (rises(j) ? p_.ascending : p_.descending).value(v);
  }

  HysteresisParameters p_;
  std::vector<double> starts_, distances_;
};

void printed_recursion(benchmark::State& run) {
  const Sweep<Hysteresis> sweep = sweep_at(run.range(0), run.range(1));
  const PrintedRecursion recursion(sweep.model.parameters(), sweep.start);
  std::size_t i = 1;
  for (auto _ : run) {
    i = i < 1023 ? i + 1 : 1;
    benchmark::DoNotOptimize(recursion.output(sweep.inputs[i]));
  }
}

void reversal(benchmark::State& run) {
  const Sweep<Hysteresis> sweep = sweep_at(run.range(0), run.range(1));
  HysteresisState state = sweep.start;
  const double v = state.input, inwards = sweep.inputs.back() - v;
  for (auto _ : run) {
    benchmark::DoNotOptimize(sweep.model.advance(state, v + 0.5 * inwards).value);
    benchmark::DoNotOptimize(sweep.model.advance(state, v + 0.1 * inwards).value);
  }
  run.SetItemsProcessed(2 * run.iterations());
}

/// Performs one step past all turning points, the worst single step. It only reads the memory, so the next
/// step has the same memory.
void wipe_at_once(benchmark::State& run) {
  const Sweep<Hysteresis> sweep = sweep_at(run.range(0), run.range(1));
  for (auto _ : run) benchmark::DoNotOptimize(sweep.model.forward(sweep.start, 2.95).value);
}

/// Measures a thousand reversals and the step that wipes them out.
void nest_and_wipe(benchmark::State& run) {
  const Hysteresis model(curves(run.range(0)));
  HysteresisState state = model.at_lower_threshold(1100);
  const std::int64_t depth = run.range(1);
  while (run.KeepRunningBatch(depth + 1)) {
    nest(model, state, depth);
    benchmark::DoNotOptimize(model.advance(state, 2.95).value);
  }
}

void construction(benchmark::State& run) {
  for (auto _ : run) benchmark::DoNotOptimize(Hysteresis(curves(run.range(0))));
}

void orders_and_depths(benchmark::internal::Benchmark* of) { of->ArgsProduct({{3, 10}, {1, 10, 100, 1000}}); }
BENCHMARK(forward_step)->Apply(orders_and_depths);
BENCHMARK(inverse_step)->Apply(orders_and_depths);
BENCHMARK(creep_inverse);
BENCHMARK(spline_forward)->Arg(1)->Arg(100);
BENCHMARK(spline_inverse)->Arg(1)->Arg(100);
BENCHMARK(bare_arithmetic)->Arg(3)->Arg(10);
BENCHMARK(plays_forward)->Arg(9)->Arg(30)->Arg(100);
BENCHMARK(plays_inverse)->Arg(9)->Arg(30)->Arg(100);
BENCHMARK(preisach_everett_forward);
BENCHMARK(preisach_everett_inverse);
BENCHMARK(preisach_relays_forward);
BENCHMARK(printed_recursion)->Apply(orders_and_depths);
BENCHMARK(reversal)->Args({10, 100});
BENCHMARK(wipe_at_once)->Args({10, 10})->Args({10, 1000});
BENCHMARK(nest_and_wipe)->Args({10, 10})->Args({10, 1000});
BENCHMARK(construction)->Arg(10)->Unit(benchmark::kMillisecond);

/// Keeps the best of the repetitions: the speed without disturbance by other programs.
class Reporter : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.error_occurred || run.run_type != Run::RT_Iteration) continue;
      const double ns = 1e9 * run.cpu_accumulated_time / static_cast<double>(run.iterations);
      const std::string name = run.run_name.function_name + "/" + run.run_name.args;
      const auto place = ns_.try_emplace(name, ns).first;
      place->second = std::min(place->second, ns);
    }
  }

  void list() const {
    for (const auto& [name, ns] : ns_) std::printf("%-32s %12.1f ns\n", name.c_str(), ns);
  }

  /// Prints the figures for order 10, unless the name states another order: the best of the repetitions.
  void compare(hystcan::bench::Budgets& budgets) const {
    budgets.print_heading();
    const double step = ns("forward_step/10/1"), deep = ns("forward_step/10/1000");
    const double back = ns("inverse_step/10/100");
    const double bare = ns("bare_arithmetic/10");
    budgets.ratio("forward step / its polynomial and exponential alone", step / bare, {1.4});
    budgets.ratio("forward step, depth 1000 / depth 1", deep / step, {1.2});
    budgets.ratio("forward step / 30 play operators", step / ns("plays_forward/30"), {0.6});
    budgets.ratio("forward step with splines / with polynomials", ns("spline_forward/1") / step, {1.0});
    budgets.ratio("inverse step, depth 100, with splines / with polynomials", ns("spline_inverse/100") / back,
                  {1.0});
    budgets.ratio("inverse step with its advance / the same arithmetic", back / bare, {6.0});
    budgets.ratio("inverse step with creep / without", ns("creep_inverse/") / back, {1.3, 2.3});
    budgets.print("forward step, depth 1, ns", step);
    budgets.print("forward step, depth 1000, ns", deep);
    budgets.print("inverse step with its advance, depth 100, ns", back);
    budgets.print("forward step, order 3, ns", ns("forward_step/3/1"));
    budgets.print("inverse step with its advance, order 3, ns", ns("inverse_step/3/100"));
    budgets.print("inverse step, depth 1000 / depth 1", ns("inverse_step/10/1000") / ns("inverse_step/10/1"));
    budgets.print("forward step / 9 play operators", step / ns("plays_forward/9"));
    budgets.print("forward step / 100 play operators", step / ns("plays_forward/100"));
    budgets.print("inverse step / inverse of 30 play operators", back / ns("plays_inverse/30"));
    budgets.print("forward step / Preisach 100 x 100, Everett form", step / ns("preisach_everett_forward/"));
    budgets.print("forward step / Preisach 100 x 100, relays", step / ns("preisach_relays_forward/"));
    for (const char* depth : {"1", "10", "100", "1000"})
      budgets.print(
          std::string("forward step / printed recursion, depth ") + depth,
          ns(std::string("forward_step/10/") + depth) / ns(std::string("printed_recursion/10/") + depth));
    budgets.print("one step that wipes 1000 levels out, ns", ns("wipe_at_once/10/1000"));
    budgets.print("1000 reversals and their wipe, ns per step", ns("nest_and_wipe/10/1000"));
    budgets.print("the same / of 10 reversals", ns("nest_and_wipe/10/1000") / ns("nest_and_wipe/10/10"));
  }

 private:
  /// Returns the time in ns; NaN if the user's options excluded the benchmark.
  double ns(const std::string& name) const {
    return ns_.contains(name) ? ns_.at(name) : std::numeric_limits<double>::quiet_NaN();
  }

  std::map<std::string, double> ns_;
};

}  // namespace

// Five repetitions of each in random order, so that the load of other programs affects all equally. The
// user's options follow and have precedence; only they can exclude a benchmark.
int main(int argc, char** argv) {
  std::vector<std::string> words{argv[0], "--benchmark_repetitions=5", "--benchmark_min_time=0.05",
                                 "--benchmark_enable_random_interleaving=true"};
  if (hystcan::bench::is_short()) words[2] = "--benchmark_min_time=0.002";
  words.insert(words.end(), argv + 1, argv + argc);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  Reporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.list();
  hystcan::bench::Budgets budgets("bench_model");
  reporter.compare(budgets);
  return argc > 1 ? 0 : budgets.status();
}
