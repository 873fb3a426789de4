// A measured dataset: the applied input and the measured output, with its turning points and half cycles.
//
// The caller of an identification owns the datasets. The identification refers to them (excerpt.h). It copies
// a dataset only to change it: to fold its inputs, or to remove dynamics, a map or unseen samples.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "model/reference_curve.h"

namespace hystcan::identification {

/// Limits of inputs and outputs in their units, and of times in s: beyond them, squares and powers of a fit
/// overflow or vanish. A column that is not constant must vary by at least `least_span`.
inline constexpr double largest_value = 1e12;
inline constexpr double least_span = 1e-12;

/// Columns of equal length. Every number is finite and within the limits, and time increases strictly.
struct Dataset {
  std::string input_unit{};  ///< empty: unknown
  std::string output_unit{};
  std::vector<double> time_s{};
  std::vector<double> input{};
  std::vector<double> output{};
  std::vector<double> weight{};  ///< weight of each sample's error in a fit; empty: all 1
  std::vector<int> fold{};       ///< fold of each sample in a fit: 0 or more, or Regression::left_out
  /// Columns that are fitted to the output in addition to the curves, without weights.
  std::vector<std::vector<double>> regressors{};

  std::size_t size() const { return input.size(); }
};

/// Returns the time from -1/2 at the first sample to 1/2 at the last one, the form of a linear drift.
inline double drift_course(std::span<const double> time_s, std::size_t i) {
  return (time_s[i] - time_s.front()) / (time_s.back() - time_s.front()) - 0.5;
}

/// Returns the smallest and largest value of a column.
model::Interval range_of(const std::vector<double>& values);
inline double span_of(const std::vector<double>& values) { return range_of(values).span(); }
double median(std::vector<double> values);

/// Returns the samples at which the input reverses after a swing of more than `least_swing`.
std::vector<std::size_t> turning_points(const Dataset& dataset, double least_swing);

/// Returns the smallest swing that counts as a turning point in a search. `span` is the input span of all
/// datasets. Smaller swings are noise, and the kept samples are enough to follow them.
double least_swing(const Dataset& dataset, double span);

/// The samples between two turning points, including both.
struct HalfCycle {
  std::size_t begin = 0, end = 0;  ///< index of the first sample, and one past the last
  double from = 0.0, to = 0.0;     ///< inputs of the first and the last sample
};

/// Returns all samples, divided at the turning points.
std::vector<HalfCycle> half_cycles(const Dataset& dataset, double least_swing);

/// Returns the dataset with |v| instead of v.
Dataset folded(const Dataset& dataset);

/// Groups of samples that are held out together: whole cycles, so that a model predicts unseen cycles, or
/// whole records, so that it predicts another session.
///
/// Fold 0 is never held out. It contains the first cycles that reach the ends of the input range, because a
/// model is not valid beyond them. The other cycles are assigned in turn to folds 1 to count - 1.
struct Folds {
  std::vector<std::vector<int>> of;  ///< the fold of each sample, per dataset
  int count = 1;                     ///< 1: too few cycles to hold one out
  std::size_t cycles = 0;
};

/// `observed`: input range of all datasets. A cycle lasts from one lower turning point to the next; swings
/// below a fiftieth of the range do not count as cycles.
Folds assign_folds(const std::vector<Dataset>& datasets, model::Interval observed);

/// For several datasets: the cycles of dataset i whose inputs are within the inputs of the other datasets are
/// fold i + 1; the rest is fold 0.
Folds records_as_folds(const std::vector<Dataset>& datasets, model::Interval observed);

}  // namespace hystcan::identification
