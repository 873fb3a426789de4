// Identifies a model from a dataset of 100 000 samples, and from three datasets with a million in all. Prints
// the processor time with its budget, then the memory for several numbers of samples. Also prints the longest
// time between checks of the stop signal, which delays Ctrl-C, in the identification and in the comparison of
// a report.
//
//   bench_identify
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "identification/baselines/comparison.h"
#include "identification/identify.h"
#include "model/hysteresis.h"
#include "tests/bench/budgets.h"
#include "tests/bench/short_run.h"

namespace {

using namespace hystcan;
using namespace hystcan::identification;

const std::size_t samples = bench::full_or_short(100'000, 10'000);
const std::size_t samples_of_three = bench::full_or_short(1'000'000, 30'000);
const int repetitions = bench::full_or_short(3, 1);

/// Returns thirty cycles of 30 um between a fixed lower and a rising upper turning point, then nested ones;
/// the noise is 0.1 %.
Dataset made(std::size_t count) {
  const model::Interval range{0.0, 100.0};
  const model::Hysteresis truth({"V",
                                 "um",
                                 {model::Basis::power, {0.0, 0.25, 4e-4, 1e-6}, range},
                                 {model::Basis::power, {0.8, 0.372, -8e-4}, range},
                                 0.05,
                                 0.04,
                                 model::Symmetry::none});
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.03);
  model::HysteresisState state = truth.at_lower_threshold();
  Dataset dataset{"V", "um", {}, {}, {}};
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(count - 1);
    const double height = t < 0.5 ? 0.2 + 1.6 * t : 1.0 - 1.2 * (t - 0.5);
    const double low = t < 0.5 ? 0.0 : 60.0 * (t - 0.5);
    const double swing = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * 30.0 * t);
    dataset.time_s.push_back(1e-4 * static_cast<double>(i));
    dataset.input.push_back(low + (100.0 * height - low) * swing);
    dataset.output.push_back(truth.advance(state, dataset.input.back()).value + noise(random));
  }
  return dataset;
}

Identified identified(const Dataset& dataset, std::optional<int> order) {
  IdentifyOptions options;
  if (order) options.shape = identification::CurveShape::polynomial(*order);
  return identify({dataset}, options);
}

void time_it(bench::Budgets& budgets, const char* what, const Dataset& dataset, std::optional<int> order) {
  double best_s = 0.0;
  Identified found;
  for (int i = 0; i < repetitions; ++i) {
    const std::clock_t before = std::clock();
    found = identified(dataset, order);
    const double now_s = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    best_s = i == 0 ? now_s : std::min(best_s, now_s);
  }
  std::printf("%zu samples, %s: order %d, %.3f %% RMS\n", dataset.size(), what, found.search.shape.order,
              100.0 * found.overall.rms / found.output_span);
  budgets.print(std::string(what) + ", s", best_s, {2.0});
}

/// Measures the longest time between two calls.
class Patience {
 public:
  bool look() {
    const Clock::time_point now = Clock::now();
    longest_s_ = std::max(longest_s_, std::chrono::duration<double>(now - last_).count());
    last_ = now;
    return true;
  }
  double longest_s() {
    look();
    return longest_s_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
  double longest_s_ = 0.0;
};

/// Identifies from three datasets with different zeros, at three rates.
void time_three(bench::Budgets& budgets, std::size_t count) {
  std::vector<Dataset> datasets;
  for (int i = 0; i < 3; ++i) {
    datasets.push_back(made(count / 3));
    for (double& t : datasets.back().time_s) t /= 1.0 + i;
    for (double& x : datasets.back().output) x += 0.5 * i;
  }
  Patience search;
  IdentifyOptions options;
  options.go_on = [&search] { return search.look(); };
  const std::clock_t before = std::clock();
  const Identified found = identify(datasets, options);
  const double took_s = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  const double answer_s = search.longest_s();
  std::printf("%zu samples in three datasets: %s, %.3f %% RMS\n", count, found.search.shape.text().c_str(),
              100.0 * found.overall.rms / found.output_span);
  budgets.print("three datasets, s", took_s, {5.0});
  Patience report;
  compare(datasets, found, [&report] { return report.look(); });
  const double report_s = report.longest_s();
  for (const auto& [what, seconds] :
       {std::pair{"identification", answer_s}, std::pair{"comparison", report_s}})
    budgets.print(std::string(what) + ", longest time without a look at the stop signal, s", seconds, {0.2});
}

/// Returns the peak memory of a child process that makes the dataset and, if `identifying`, identifies from
/// it.
double peak_MB(std::size_t count, bool identifying) {
  const pid_t child = fork();
  if (child == 0) {
    const Dataset dataset = made(count);
    if (identifying) identified(dataset, 10);
    _exit(0);
  }
  int status = 0;
  rusage usage{};
  if (wait4(child, &status, 0, &usage) != child || status != 0)
    throw std::runtime_error("the identification in a child process failed");
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace

int main() {
  bench::Budgets budgets("bench_identify");
  const double small = peak_MB(samples, true) - peak_MB(samples, false);
  const double large = peak_MB(4 * samples, true) - peak_MB(4 * samples, false);
  const Dataset dataset = made(samples);
  time_it(budgets, "order chosen", dataset, std::nullopt);
  time_it(budgets, "order 10", dataset, 10);
  time_three(budgets, samples_of_three);
  std::printf("memory beside the dataset's own: %zu samples %.1f MB, %zu samples %.1f MB\n", samples, small,
              4 * samples, large);
  budgets.computed("memory of four times the samples / once", large / small, {4.4});
  return budgets.status();
}
