// Figures of a benchmark beside their budgets, and the exit status that follows from them.
//
// A figure that hardly depends on the machine is judged: a ratio of two times of one run, the best of several
// repetitions each, or a computed figure (an error, a count). The program fails if such a figure exceeds its
// budget by more than an allowance. A time or a rate depends on the machine: it is printed, not judged.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace hystcan::bench {

/// Allowance of a ratio of two times: a busy machine shares its caches, which slows the larger program down.
constexpr double timing_allowance = 2.0;
/// Allowance of a computed figure: only compilers and libraries differ.
constexpr double computed_allowance = 1.02;

struct Budget {
  double at_most = 0.0;
  /// The present figure of a budget that is missed: the figure may not become worse.
  double accepted = 0.0;
};

/// Prints a line for each figure and remembers whether one fails. With HYSTCAN_BENCH_FIGURES in the
/// environment, appends the judged figures to this file as rows of docs/evidence/budgets.csv.
class Budgets {
 public:
  explicit Budgets(std::string program) : program_(std::move(program)) {}

  void ratio(const std::string& what, double figure, const Budget& budget) {
    judge(what, figure, budget, timing_allowance);
  }
  void computed(const std::string& what, double figure, const Budget& budget) {
    judge(what, figure, budget, computed_allowance);
  }
  /// A time or a rate, with its unit in `what`.
  void print(const std::string& what, double figure, const Budget& budget = {}) const {
    const std::string text = budget.at_most > 0.0 ? "  " + shown(budget.at_most) + "  not judged" : "";
    std::printf("%-62s %10.3f%s\n", what.c_str(), figure, text.c_str());
  }
  static void print_heading() { std::printf("%-62s %10s  %6s\n", "", "", "budget"); }

  /// The exit status of the program.
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
    if (!(figure <= limit)) {  // also if it is not a number
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
