// Compares the figures of a benchmark with their budgets and sets the exit status.
//
// A figure that hardly depends on the machine is judged: a ratio of two times of one run, each the best of
// several repetitions, or a computed figure (an error, a count). The program fails if such a figure exceeds
// its budget by more than an allowance. A time or a rate depends on the machine: it is printed, not judged.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace hystcan::bench {

/// Allowance for a ratio of two times: on a busy machine, shared caches slow the larger program down.
constexpr double timing_allowance = 2.0;
/// Allowance for a computed figure, which depends only on compilers and libraries.
constexpr double computed_allowance = 1.02;

struct Budget {
  double at_most = 0.0;
  /// Present figure if it exceeds the budget: the figure must not become worse.
  double accepted = 0.0;
};

/// Prints a line for each figure and stores whether one failed. If HYSTCAN_BENCH_FIGURES is set, appends the
/// judged figures to this file as rows of docs/evidence/budgets.csv.
class Budgets {
 public:
  explicit Budgets(std::string program) : program_(std::move(program)) {}

  void ratio(const std::string& what, double figure, const Budget& budget) {
    judge(what, figure, budget, timing_allowance);
  }
  void computed(const std::string& what, double figure, const Budget& budget) {
    judge(what, figure, budget, computed_allowance);
  }
  /// Prints a time or a rate; its unit is in `what`.
  void print(const std::string& what, double figure, const Budget& budget = {}) const {
    const std::string text = budget.at_most > 0.0 ? "  " + shown(budget.at_most) + "  not judged" : "";
    std::printf("%-62s %10.3f%s\n", what.c_str(), figure, text.c_str());
  }
  static void print_heading() { std::printf("%-62s %10s  %6s\n", "", "", "budget"); }

  /// Returns the exit status of the program.
  int status() const { return failed_ ? EXIT_FAILURE : EXIT_SUCCESS; }

 private:
  static std::string shown(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%6.4g", number);
    return text;
  }

  void judge(const std::string& what, double figure, const Budget& budget, double allowance) {
    const double limit = allowance * std::max(budget.at_most, budget.accepted);
    const char* verdict = figure <= budget.at_most ? "met" : figure <= limit ? "missed" : "FAILED";
    std::printf("%-62s %10.3f  %s  %s\n", what.c_str(), figure, shown(budget.at_most).c_str(), verdict);
    if (!(figure <= limit)) {  // true for NaN too
      failed_ = true;
      std::fprintf(stderr, "%s: %s: %.4g; the budget is %.4g, and %.4g is the limit with its allowance\n",
                   program_.c_str(), what.c_str(), figure, budget.at_most, limit);
    }
    const char* file = std::getenv("HYSTCAN_BENCH_FIGURES");
    if (file == nullptr) return;
    std::FILE* const rows = std::fopen(file, "a");
    failed_ = failed_ || rows == nullptr;
    if (rows == nullptr) return;
    std::fprintf(rows, "%s,\"%s\",%.3g,%.4g,%s\n", program_.c_str(), what.c_str(), figure, budget.at_most,
                 verdict);
    std::fclose(rows);
  }

  std::string program_;
  bool failed_ = false;
};

}  // namespace hystcan::bench
