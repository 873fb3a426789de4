// Fewer rows that show the same: of each `bucket` consecutive rows of an axis the least and the largest value of each
// column. NaN counts only if all are NaN.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

namespace hystcan::app {

class RowDecimator {
 public:
  /// `axis_column` has the axis of a row. A bucket of 1 or 2 rows: each row as it is.
  RowDecimator(std::size_t columns, std::size_t axis_column, std::size_t bucket);
  /// The bucket that leaves at most `most_Hz` rows of an axis from `rate_Hz`.
  static std::size_t bucket_for(double rate_Hz, double most_Hz);

  void put(std::span<const double> row);
  /// What has come out since the last call.
  std::vector<double> take();

 private:
  struct Bucket {
    std::vector<double> least, largest;
    std::size_t rows = 0;
  };

  std::size_t columns_, axis_column_, bucket_;
  std::map<std::size_t, Bucket> open_;  ///< per axis
  std::vector<double> out_;
};

}  // namespace hystcan::app
