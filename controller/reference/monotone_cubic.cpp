#include "controller/reference/monotone_cubic.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace hystcan::controller {
namespace {

bool finite(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

}  // namespace

MonotoneCubic::MonotoneCubic(std::vector<double> x, std::vector<double> y)
    : x_(std::move(x)), y_(std::move(y)), slope_(x_.size(), 0.0) {
  if (x_.size() < 2 || x_.size() != y_.size())
    throw std::invalid_argument("the curve has too few points, expected two or more, as many y as x");
  if (!finite(x_) || !finite(y_) || std::ranges::adjacent_find(x_, std::greater_equal{}) != x_.end())
    throw std::invalid_argument("the curve's points are not in order, expected finite ones, x increasing");
  const double first = x_.front();
  for (double& value : x_) value -= first;
  for (std::size_t i = 1; i + 1 < x_.size(); ++i) {
    const double before = x_[i] - x_[i - 1];
    const double after = x_[i + 1] - x_[i];
    const double d_before = (y_[i] - y_[i - 1]) / before;
    const double d_after = (y_[i + 1] - y_[i]) / after;
    if ((d_before > 0.0) != (d_after > 0.0) || d_before == 0.0 || d_after == 0.0) continue;
    slope_[i] =
        3.0 * (before + after) / ((2.0 * after + before) / d_before + (after + 2.0 * before) / d_after);
  }
}

MonotoneCubic::Point MonotoneCubic::at(double x) const {
  if (x_.empty()) return {};
  if (x < x_.front()) return {.value = y_.front()};
  if (x >= x_.back()) return {.value = y_.back()};
  const auto i = static_cast<std::size_t>(std::ranges::upper_bound(x_, x) - x_.begin() - 1);
  return on_piece(i, x - x_[i]);
}

/// y_i + m_i u + c2 u^2 + c3 u^3,  u = x - x_i.
MonotoneCubic::Point MonotoneCubic::on_piece(std::size_t i, double u) const {
  const double h = x_[i + 1] - x_[i];
  const double d = (y_[i + 1] - y_[i]) / h;
  const double c2 = (3.0 * d - 2.0 * slope_[i] - slope_[i + 1]) / h;
  const double c3 = (slope_[i] + slope_[i + 1] - 2.0 * d) / (h * h);
  return {.value = y_[i] + u * (slope_[i] + u * (c2 + u * c3)),
          .slope = slope_[i] + u * (2.0 * c2 + u * 3.0 * c3),
          .curvature = 2.0 * c2 + 6.0 * c3 * u};
}

/// The slope of a piece is a parabola: greatest at an end or where the curvature, which is linear, vanishes.
MonotoneCubic::Range MonotoneCubic::range() const {
  if (x_.empty()) return {};
  const auto [lowest, highest] = std::ranges::minmax(y_);
  Range range{.lowest = lowest, .highest = highest};
  const auto take = [&](const Point& point) {
    range.peak_slope = std::max(range.peak_slope, std::abs(point.slope));
    range.peak_curvature = std::max(range.peak_curvature, std::abs(point.curvature));
  };
  for (std::size_t i = 0; i + 1 < x_.size(); ++i) {
    const double h = x_[i + 1] - x_[i];
    const Point begin = on_piece(i, 0.0);
    const Point end = on_piece(i, h);
    take(begin);
    take(end);
    if ((begin.curvature > 0.0) != (end.curvature > 0.0))
      take(on_piece(i, h * begin.curvature / (begin.curvature - end.curvature)));
  }
  return range;
}

}  // namespace hystcan::controller
