// The last rows of a stream, for clients that come later and for captures. Bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hystcan::app {

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

}  // namespace hystcan::app
