#include "app/page/row_decimator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::app {

RowDecimator::RowDecimator(std::size_t columns, std::size_t axis_column, std::size_t bucket)
    : columns_(columns), axis_column_(axis_column), bucket_(bucket) {}

std::size_t RowDecimator::bucket_for(double rate_Hz, double most_Hz) {
  if (!(rate_Hz > most_Hz)) return 1;
  return static_cast<std::size_t>(std::ceil(2.0 * rate_Hz / most_Hz));  // each bucket becomes two rows
}

void RowDecimator::put(std::span<const double> row) {
  if (bucket_ <= 2) {
    out_.insert(out_.end(), row.begin(), row.end());
    return;
  }
  Bucket& bucket = open_[static_cast<std::size_t>(row[axis_column_])];
  if (bucket.rows == 0) {
    bucket.least.assign(row.begin(), row.end());
    bucket.largest = bucket.least;
  } else {
    for (std::size_t i = 0; i < columns_; ++i) {  // fmin and fmax prefer a number to NaN
      bucket.least[i] = std::fmin(bucket.least[i], row[i]);
      bucket.largest[i] = std::fmax(bucket.largest[i], row[i]);
    }
  }
  if (++bucket.rows < bucket_) return;
  bucket.rows = 0;
  out_.insert(out_.end(), bucket.least.begin(), bucket.least.end());
  out_.insert(out_.end(), bucket.largest.begin(), bucket.largest.end());
}

std::vector<double> RowDecimator::take() { return std::exchange(out_, {}); }

}  // namespace hystcan::app
