// The rows of a stream: the last ones, and fewer that show the same.
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

/// The last rows, for clients that come later and for captures. Bounded.
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
  /// Rows [first(), end()) are there; rows are counted from the beginning of the stream.
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

/// The column of this name in a stream with this greeting; empty if there is none.
std::optional<std::size_t> column_in(const StreamGreeting& greeting, std::string_view name);

/// Of some consecutive rows of an axis the least and the largest value of each column. NaN counts only if all
/// are NaN. A change of `state` or `fault` is never within such rows, and a bit of `limits` that was set is
/// set in the second one.
class RowDecimator {
 public:
  /// The stream has a column `axis`. `bucket`: rows that become two. 1 or 2: each row as it is.
  RowDecimator(const StreamGreeting& greeting, std::size_t bucket);
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

  bool is_another_state(const Bucket& bucket, std::span<const double> row) const;
  void join(Bucket& bucket, std::span<const double> row) const;
  void empty(Bucket& bucket);

  std::size_t axis_;
  std::vector<std::size_t> states_;
  std::optional<std::size_t> bits_;
  std::size_t bucket_;
  std::map<std::size_t, Bucket> open_;  ///< per axis
  std::vector<double> out_;
};

}  // namespace hystcan::app
