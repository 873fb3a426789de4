#include "identification/dynamics/empirical_response.h"

#include <Eigen/Core>
#include <algorithm>

#include "identification/quasi_static.h"
#include "model/spectrum.h"

namespace hystcan::identification {
namespace {

Eigen::VectorXd differences(const Eigen::VectorXd& values) {
  return values.tail(values.size() - 1) - values.head(values.size() - 1);
}

Eigen::VectorXd interpolated_on(const Grid& grid, const std::vector<double>& column) {
  Eigen::VectorXd values(grid.length());
  values[0] = column[0];
  for (std::size_t n = 1; n < column.size(); ++n) {
    const Eigen::Index from = grid.cycles[n - 1], to = grid.cycles[n];
    for (Eigen::Index i = from + 1; i <= to; ++i) {
      const double share = static_cast<double>(i - from) / static_cast<double>(to - from);
      values[i] = column[n - 1] + share * (column[n] - column[n - 1]);
    }
  }
  return values;
}

/// Returns the length of a segment: the largest power of two that gives at least eight segments. The length
/// is limited to the range from 64 to 1024.
Eigen::Index segment_length(Eigen::Index rows) {
  constexpr Eigen::Index shortest = 64, longest = 1024;
  Eigen::Index length = shortest;
  while (length < longest && 9 * length <= 2 * rows) length *= 2;
  return 9 * length / 2 <= rows || length == shortest ? length : length / 2;
}

}  // namespace

std::vector<ResponsePoint> empirical_response(const Dataset& dataset) {
  constexpr double excited = 1e-6;
  if (dataset.size() < 3) return {};
  const Grid grid = grid_of(dataset.time_s);
  const Eigen::VectorXd input = differences(held_on(grid, dataset.input));
  const Eigen::VectorXd output = differences(interpolated_on(grid, dataset.output));
  const Eigen::Index length = segment_length(input.size());
  const model::HannTransform transform(static_cast<std::size_t>(length));
  const auto transformed = [&](const Eigen::VectorXd& of, Eigen::Index first) -> Eigen::ArrayXcd {
    const auto spectrum = transform({of.data() + first, transform.length()});
    return Eigen::Map<const Eigen::ArrayXcd>(spectrum.data(), length / 2);
  };
  Eigen::ArrayXd input_power = Eigen::ArrayXd::Zero(length / 2), output_power = input_power;
  Eigen::ArrayXcd cross = Eigen::ArrayXcd::Zero(length / 2);
  for (Eigen::Index first = 0; first + length <= input.size(); first += length / 2) {
    const Eigen::ArrayXcd u = transformed(input, first), y = transformed(output, first);
    input_power += u.abs2();
    output_power += y.abs2();
    cross += u.conjugate() * y;
  }
  std::vector<ResponsePoint> points;
  for (Eigen::Index k = 1; k < length / 2; ++k)
    if (input_power[k] > excited * input_power.maxCoeff())
      points.push_back(
          {.frequency_Hz = static_cast<double>(k) / (static_cast<double>(length) * grid.cycle_s),
           .response = cross[k] / input_power[k],
           .coherence = std::norm(cross[k]) / std::max(input_power[k] * output_power[k], 1e-300)});
  return points;
}

}  // namespace hystcan::identification
