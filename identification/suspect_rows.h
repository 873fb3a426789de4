// Finds errors of a measurement, before an identification: drop-outs and glitches, a sensor at the end of its
// range, and the same record given twice.
#pragma once

#include <cstddef>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::identification {

/// A row with a value that no stage can have: it is far from the rows on both sides. In the first or last
/// rows of a record, it is far from the rows on one side.
struct SuspectRow {
  std::size_t row = 0;
  bool of_input = false;  ///< true: a value of the input; false: a value of the output
  double value = 0.0;
  double usual = 0.0;  ///< median of the rows around this row, the expected value
};

/// Finds suspect rows: runs of at most eight rows that are far from the median of the 17 rows around each row
/// (a Hampel filter). The distance of a row from this median must exceed all of these limits:
///
///   20 times the noise, and 2 % of the range
///   10 times the upper quartile of the steps from row to row within the 17 rows
///   3 times the fourth largest step from row to row elsewhere in the record
///   for an output: 10 times the average effect of the largest step of the input within the 17 rows
///
/// If the inputs have more than three such runs, and more than two in a thousand rows, these are pulses of
/// the excitation. Then no row is suspect. The drive may also begin or end with a jump. Therefore an input in
/// the first or last rows of the record is suspect only if it is outside the range of the other inputs and
/// the output does not follow it.
std::vector<SuspectRow> suspect_rows(const Dataset& dataset);

/// A sensor at the end of its range: the output has exactly its extreme value while the input moves.
struct SensorEnd {
  double value = 0.0;
  bool is_upper = true;
  std::size_t rows = 0;
};

/// Finds out whether the sensor was at the lower or the upper end of its range. At such an end, the output
/// has exactly its extreme value in consecutive rows, while the input travels 5 % of its range or more. The
/// three largest steps of the input do not count: if the stage has a delay, its output stays constant for
/// some rows after the drive has jumped. Immediately before or after these rows, the output must have a slope
/// of more than three tenths of its mean slope in the record. The output of a saturated material would bend
/// smoothly instead. An end is returned only if more than 1 % of all rows are at this end.
std::vector<SensorEnd> sensor_ends(const Dataset& dataset);

/// Returns the dataset without the suspect rows. Its weights, folds and regressors are empty.
Dataset without_rows(const Dataset& dataset, const std::vector<SuspectRow>& suspects);

/// Returns true if the longer dataset contains all rows of the shorter one, in one piece. Values are equal if
/// they differ by less than a millionth of their range. Returns false if the shorter dataset has fewer than
/// `least_samples` rows.
bool has_same_rows(const Dataset& a, const Dataset& b);

}  // namespace hystcan::identification
