// Rows of numbers from the thread that makes them to the one that sends them. Bounded: rows that nobody takes are counted
// and dropped, the oldest stay.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

namespace hystcan::app {

class SampleBoard {
 public:
  struct Rows {
    std::vector<double> values{};  ///< row by row
    std::uint32_t lost = 0;        ///< rows after these that had no place
  };

  /// `most_rows` between two calls of take().
  SampleBoard(std::size_t columns, std::size_t most_rows) : columns_(columns), most_rows_(most_rows) {
    rows_.values.reserve(columns_ * most_rows_);
  }

  std::size_t columns() const { return columns_; }
  /// Without a listener put() costs one load.
  void set_listening(bool listening) { listening_.store(listening, std::memory_order_relaxed); }
  bool is_listening() const { return listening_.load(std::memory_order_relaxed); }

  void put(std::span<const double> row) {
    const std::scoped_lock lock(mutex_);
    if (rows_.values.size() >= columns_ * most_rows_)
      ++rows_.lost;
    else
      rows_.values.insert(rows_.values.end(), row.begin(), row.end());
  }

  /// Exchanges what has come for `empty`, whose storage is used again.
  void take(Rows& empty) {
    empty.values.clear();
    empty.values.reserve(columns_ * most_rows_);
    empty.lost = 0;
    const std::scoped_lock lock(mutex_);
    std::swap(rows_, empty);
  }

 private:
  std::size_t columns_, most_rows_;
  std::atomic<bool> listening_{false};
  std::mutex mutex_;
  Rows rows_;
};

}  // namespace hystcan::app
