// Rows of a record that no stage makes: drop-outs and glitches, a sensor at its end, a record given twice.
#pragma once

#include <cstddef>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::identification {

/// A value that differs from the rows on both sides; at an end of the record, from those on the one side.
struct SuspectRow {
  std::size_t row = 0;
  bool of_input = false;  ///< else of the output
  double value = 0.0;
  double usual = 0.0;  ///< median of the rows around it
};

/// A run of at most eight rows that the median of the 17 rows around each does not follow (a Hampel filter).
/// Its distance from the median exceeds each of these:
///   20 times the noise, 2 % of the range
///   10 times the upper quartile of the steps around it
///   3 times the fourth largest step from row to row elsewhere in the record
///   output: 10 times what the largest step of the input around it does on average
/// More such runs of the input than three, and than two in a thousand rows, are pulses of the excitation:
/// then no row is suspect. A drive can begin and end with a jump: there, an input is suspect only outside the
/// range of the others and if no output follows.
std::vector<SuspectRow> suspect_rows(const Dataset& dataset);

/// An output that stands still at its extreme value while the input moves.
struct SensorEnd {
  double value = 0.0;
  bool is_upper = true;
  std::size_t rows = 0;
};

/// Stretches of the very same extreme value in which the input travels 5 % of its range or more (without its
/// three largest steps, as a delay holds the output while the drive jumps), and beside which the output moves
/// at three tenths of its mean slope or more: a saturation of the material bends smoothly into its end. None
/// if they are fewer than 1 % of the rows.
std::vector<SensorEnd> sensor_ends(const Dataset& dataset);

/// The dataset without the rows of these. Weights, folds and regressors are left empty.
Dataset without_rows(const Dataset& dataset, const std::vector<SuspectRow>& suspects);

/// True if all rows of the shorter one follow one another in the longer one, to a millionth of the range.
bool has_same_rows(const Dataset& a, const Dataset& b);

}  // namespace hystcan::identification
