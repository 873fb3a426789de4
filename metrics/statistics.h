// Statistics of a series of values. They are updated value by value, so that the memory does not grow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hystcan::metrics {

struct ErrorStatistics {
  std::size_t samples = 0;
  double sum_of_squares = 0.0;
  double max_um = 0.0;  ///< largest magnitude of an error

  void add(double error_um);
  void add(const ErrorStatistics& others);
  double rms_um() const;
};

/// Counts how many values are in each class. A class contains the values above the previous upper edge, up to
/// and including its own upper edge. One more class, the last, counts all values above the highest edge.
class Histogram {
 public:
  explicit Histogram(std::vector<double> upper_edges)
      : upper_edges_(std::move(upper_edges)), counts_(upper_edges_.size() + 1) {}
  /// Creates `classes` classes of equal width, starting at 0. One more class counts all larger values.
  static Histogram of_width(double width, std::size_t classes);

  /// Counts the value in its class. Ignores a value that is not finite.
  void add(double value);

  const std::vector<double>& upper_edges() const { return upper_edges_; }
  /// Returns the number of values in each class. The last number counts the values above the highest edge.
  const std::vector<std::uint64_t>& counts() const { return counts_; }
  std::uint64_t samples() const { return samples_; }
  double sum() const { return sum_; }

 private:
  std::vector<double> upper_edges_;
  std::vector<std::uint64_t> counts_;
  std::uint64_t samples_ = 0;
  double sum_ = 0.0;
};

}  // namespace hystcan::metrics
