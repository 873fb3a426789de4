#include "app/page/stream_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::app {

std::optional<std::size_t> column_in(const StreamGreeting& greeting, std::string_view name) {
  const auto found = std::ranges::find(greeting.columns, name, &StreamColumn::name);
  if (found == greeting.columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - greeting.columns.begin());
}

RowDecimator::RowDecimator(const StreamGreeting& greeting, std::size_t bucket)
    : axis_(column_in(greeting, "axis").value()), bits_(column_in(greeting, "limits")), bucket_(bucket) {
  for (const char* name : {"state", "fault"})
    if (const auto column = column_in(greeting, name)) states_.push_back(*column);
}

std::size_t RowDecimator::bucket_for(double rate_Hz, double most_Hz) {
  if (!(rate_Hz > most_Hz)) return 1;
  // The factor is 2, because each bucket becomes two rows.
  return static_cast<std::size_t>(std::ceil(2.0 * rate_Hz / most_Hz));
}

void RowDecimator::put(std::span<const double> row) {
  if (bucket_ <= 2) {
    out_.insert(out_.end(), row.begin(), row.end());
    return;
  }
  Bucket& bucket = open_[static_cast<std::size_t>(row[axis_])];
  if (bucket.rows > 0 && is_another_state(bucket, row)) empty(bucket);
  join(bucket, row);
  if (++bucket.rows == bucket_) empty(bucket);
}

bool RowDecimator::is_another_state(const Bucket& bucket, std::span<const double> row) const {
  return std::ranges::any_of(states_, [&](std::size_t i) { return bucket.least[i] != row[i]; });
}

void RowDecimator::join(Bucket& bucket, std::span<const double> row) const {
  if (bucket.rows == 0) {
    bucket.least.assign(row.begin(), row.end());
    bucket.largest = bucket.least;
    return;
  }
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i == bits_) {
      bucket.largest[i] =
          static_cast<double>(static_cast<unsigned>(bucket.largest[i]) | static_cast<unsigned>(row[i]));
      continue;
    }
    // fmin and fmax ignore NaN if the other value is a number.
    bucket.least[i] = std::fmin(bucket.least[i], row[i]);
    bucket.largest[i] = std::fmax(bucket.largest[i], row[i]);
  }
}

void RowDecimator::empty(Bucket& bucket) {
  out_.insert(out_.end(), bucket.least.begin(), bucket.least.end());
  if (bucket.rows > 1) out_.insert(out_.end(), bucket.largest.begin(), bucket.largest.end());
  bucket.rows = 0;
}

std::vector<double> RowDecimator::take() { return std::exchange(out_, {}); }

}  // namespace hystcan::app
