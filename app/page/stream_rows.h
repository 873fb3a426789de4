// Stores the rows of a stream, and reduces them to fewer rows that look the same in a chart.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "app/live/samples.h"

namespace hystcan::app {

/// Stores the last `most_rows` rows of a stream, for captures and for clients that connect later.
class RowHistory {
 public:
  RowHistory(std::size_t columns, std::size_t most_rows) : columns_(columns), most_rows_(most_rows) {}

  void put(std::span<const double> row) {
    if (values_.size() < columns_ * most_rows_)
      values_.insert(values_.end(), row.begin(), row.end());
    else
      std::copy(row.begin(), row.end(), values_.begin() + static_cast<std::ptrdiff_t>(place(count_)));
    ++count_;
  }

  std::size_t columns() const { return columns_; }
  /// Rows from first() to end() - 1 are available. Row numbers count from the start of the stream.
  std::uint64_t first() const { return count_ > most_rows_ ? count_ - most_rows_ : 0; }
  std::uint64_t end() const { return count_; }
  std::span<const double> row(std::uint64_t number) const {
    return std::span(values_).subspan(place(number), columns_);
  }

 private:
  std::size_t place(std::uint64_t number) const {
    return static_cast<std::size_t>(number % most_rows_) * columns_;
  }

  std::size_t columns_, most_rows_;
  std::uint64_t count_ = 0;
  std::vector<double> values_;
};

/// Returns the index of the column `name` in a stream with this greeting; nullopt if there is no such column.
std::optional<std::size_t> column_in(const StreamGreeting& greeting, std::string_view name);

/// Reduces groups of consecutive rows of an axis to two rows each. For every column, the first row has the
/// smallest value in the group, the second row the largest; NaN counts only if all values are NaN. In the
/// column `limits`, the second row has every bit that was set in the group. A group ends early if `state` or
/// `fault` changes.
class RowDecimator {
 public:
  /// `bucket`: number of rows in a group; with 1 or 2, all rows are kept. The stream must have a column
  /// `axis`.
  RowDecimator(const StreamGreeting& greeting, std::size_t bucket);
  /// Returns how many rows a group must have, so that a stream of `rate_Hz` is reduced to at most `most_Hz`
  /// rows per second and axis.
  static std::size_t bucket_for(double rate_Hz, double most_Hz);

  void put(std::span<const double> row);
  /// Returns the reduced rows that were completed since the last call.
  std::vector<double> take();

 private:
  struct Bucket {
    std::vector<double> least, largest;
    std::size_t rows = 0;
  };

  bool is_another_state(const Bucket& bucket, std::span<const double> row) const;
  void join(Bucket& bucket, std::span<const double> row) const;
  void empty(Bucket& bucket);

  std::size_t axis_;
  std::vector<std::size_t> states_;
  std::optional<std::size_t> bits_;
  std::size_t bucket_;
  std::map<std::size_t, Bucket> open_;  ///< for each axis, the group of rows that is not complete yet
  std::vector<double> out_;
};

}  // namespace hystcan::app
