// A measured dataset, with its applied input and its measured output, and functions for its turning points,
// half cycles and folds.
//
// The caller of an identification owns the datasets. The identification refers to them (excerpt.h). It copies
// a dataset only to change it: to fold its inputs, or to remove dynamics, an output map or unseen samples.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "model/reference_curve.h"

namespace hystcan::identification {

/// Limits for the values of a dataset. A time (in s), an input or an output must not exceed `largest_value`
/// in magnitude. A column that is not constant must vary by at least `least_span`. Beyond these limits,
/// squares and powers in a fit would overflow or vanish.
inline constexpr double largest_value = 1e12;
inline constexpr double least_span = 1e-12;

/// The columns of a measured dataset. All columns have the same length. Every number is finite and within
/// largest_value and least_span. Time increases strictly.
struct Dataset {
  std::string input_unit{};  ///< empty if the unit is not known
  std::string output_unit{};
  std::vector<double> time_s{};
  std::vector<double> input{};
  std::vector<double> output{};
  std::vector<double> weight{};  ///< weight of each sample's error in a fit; empty: all weights are 1
  /// Fold of each sample in a fit, 0 or more; Regression::left_out for a sample that is not fitted.
  std::vector<int> fold{};
  /// More columns, with one value per sample, that are fitted to the output together with the curves.
  /// `weight` does not apply to them.
  std::vector<std::vector<double>> regressors{};

  std::size_t size() const { return input.size(); }
};

/// Returns the time of sample i, scaled so that the first sample has -1/2 and the last one 1/2. A linear
/// drift is proportional to this scaled time.
inline double drift_course(std::span<const double> time_s, std::size_t i) {
  return (time_s[i] - time_s.front()) / (time_s.back() - time_s.front()) - 0.5;
}

/// Returns the smallest and the largest value of a column.
model::Interval range_of(const std::vector<double>& values);
inline double span_of(const std::vector<double>& values) { return range_of(values).span(); }
double median(std::vector<double> values);

/// Returns the indices of the samples at which the input reverses. A reversal counts if the input then moves
/// by more than `least_swing`.
std::vector<std::size_t> turning_points(const Dataset& dataset, double least_swing);

/// Returns the swing of the input above which a reversal counts as a turning point in a search. Smaller
/// swings count as noise. The search does not keep their turning points, only its evenly spaced samples.
/// `span` is the span of the inputs of all datasets.
double least_swing(const Dataset& dataset, double span);

/// A half cycle: the samples from one turning point to the next, including both.
struct HalfCycle {
  std::size_t begin = 0, end = 0;  ///< index of the first sample, and index after the last sample
  double from = 0.0, to = 0.0;     ///< inputs of the first and the last sample
};

/// Returns the half cycles of a dataset, which together contain all samples. `least_swing`: see
/// turning_points().
std::vector<HalfCycle> half_cycles(const Dataset& dataset, double least_swing);

/// Returns the dataset with the magnitude of each input, for a model with even symmetry.
Dataset folded(const Dataset& dataset);

/// Folds: groups of samples that are held out together. If a fold consists of whole cycles, its error shows
/// how well a model predicts unseen cycles. If it is a whole record, its error shows how well a model
/// predicts another session.
///
/// Fold 0 is never held out. It contains the first cycles that reach the ends of the input range, because a
/// model is not valid beyond the inputs to which it was fitted. The other cycles are assigned in turn to the
/// folds 1 to count - 1.
struct Folds {
  std::vector<std::vector<int>> of;  ///< for each dataset, the fold of each sample
  int count = 1;                     ///< number of folds; 1 if there are too few cycles to hold one out
  std::size_t cycles = 0;
};

/// Divides the cycles of all datasets into folds. `observed` is the input range of all datasets. A cycle
/// begins at a lower turning point and ends at the next one. Swings below a fiftieth of the range do not
/// count.
Folds assign_folds(const std::vector<Dataset>& datasets, model::Interval observed);

/// Assigns the cycles of two or more datasets to folds, one fold for each dataset. Fold i + 1 contains the
/// cycles of dataset i whose inputs are within the inputs of the other datasets. The rest is in fold 0.
Folds records_as_folds(const std::vector<Dataset>& datasets, model::Interval observed);

}  // namespace hystcan::identification
