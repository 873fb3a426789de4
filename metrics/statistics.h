// Statistics of a series of values in constant memory.
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

/// Counts values in classes; each class has the values up to and including its upper edge. The last class has
/// no edge and counts the rest.
class Histogram {
 public:
  explicit Histogram(std::vector<double> upper_edges)
      : upper_edges_(std::move(upper_edges)), counts_(upper_edges_.size() + 1) {}
  /// Creates classes of equal width.
  static Histogram of_width(double width, std::size_t classes);

  /// Ignores values that are not finite.
  void add(double value);

  const std::vector<double>& upper_edges() const { return upper_edges_; }
  /// Returns the count of each class; the last one is that of the class without an edge.
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
