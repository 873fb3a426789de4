// Finds rows of a record that no stage can make: drop-outs and glitches, a sensor at its end, a record given
// twice.
#pragma once

#include <cstddef>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::identification {

/// A value that differs from the rows on both sides; at an end of the record, from the rows on one side.
struct SuspectRow {
  std::size_t row = 0;
  bool of_input = false;  ///< true: a value of the input; false: a value of the output
  double value = 0.0;
  double usual = 0.0;  ///< median of the rows around it
};

/// Finds runs of at most eight rows that are far from the median of the 17 rows around each row (a Hampel
/// filter). The distance of a run from the median must exceed each of these:
///   20 times the noise, 2 % of the range
///   10 times the upper quartile of the steps around it
///   3 times the fourth largest step from row to row elsewhere in the record
///   output: 10 times the average effect of the largest step of the input around it
/// More than three such runs of the input, and more than two in a thousand rows, are pulses of the
/// excitation: no row is suspect then. A drive can begin and end with a jump. There, an input is suspect only
/// if it is outside the range of the other inputs and no output follows.
std::vector<SuspectRow> suspect_rows(const Dataset& dataset);

/// An output that stays at its extreme value while the input moves.
struct SensorEnd {
  double value = 0.0;
  bool is_upper = true;
  std::size_t rows = 0;
};

/// Finds stretches of exactly the same extreme value in which the input travels 5 % of its range or more. Its
/// three largest steps do not count, because a delay holds the output while the drive jumps. Beside the
/// stretch, the output must move at three tenths of its mean slope or more: a saturation of the material
/// bends smoothly into its end. Empty if the stretches contain fewer than 1 % of the rows.
std::vector<SensorEnd> sensor_ends(const Dataset& dataset);

/// Returns the dataset without these rows. Weights, folds and regressors stay empty.
Dataset without_rows(const Dataset& dataset, const std::vector<SuspectRow>& suspects);

/// True if the longer dataset contains all rows of the shorter one consecutively, to a millionth of the
/// range.
bool has_same_rows(const Dataset& a, const Dataset& b);

}  // namespace hystcan::identification
