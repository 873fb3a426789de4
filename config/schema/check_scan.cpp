#include "config/schema/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "controller/reference/trajectory.h"

namespace hystcan::config {
namespace {

bool is_raster(const controller::Segment& segment) {
  return std::holds_alternative<controller::Raster>(segment.shape);
}

/// An axis with at least one raster.
class ScanAxis {
 public:
  ScanAxis(const Document& document, const Config& config, std::size_t index)
      : document_(document),
        axis_(config.axes[index]),
        key_(fmt::format("axis[{}].control.setpoint", index)),
        reference_(controller::reference_of(axis_.control)) {
    const std::vector<controller::Segment>& segments = axis_.control.setpoint;
    for (std::size_t i = 0; i < segments.size(); ++i)
      if (is_raster(segments[i])) rasters_.push_back(i);
  }

  /// A first way that the limits lengthen depends on where it begins, and the scan would begin later by as
  /// much.
  void check_first_way() const {
    const controller::AxisConfig& control = axis_.control;
    const controller::Segment& first = control.setpoint.front();
    const model::Interval reach = control.law.model.output_range();
    const double first_um = value_um(prepared(first.shape), 0.0);
    const double furthest_um = std::max(std::abs(first_um - reach.lo), std::abs(first_um - reach.hi));
    const double least_s =
        controller::Transition::within(tighter(control.reference_limits, control.transition_limits), {},
                                       furthest_um, first.transition_s)
            .duration_s();
    if (least_s > first.transition_s * rounding)
      document_.fail_at(
          key_ + "[0].transition_s",
          fmt::format("transition_s is {:g}, expected at least {:.3g}: the limits of the reference ask "
                      "for as much from the far end, and the axes of a scan begin it together",
                      first.transition_s, least_s));
  }

  /// The same lines at the same time.
  void compare_with(const ScanAxis& other) const {
    if (rasters_.size() != other.rasters_.size())
      fail("", "rasters", rasters_.size(), other.rasters_.size(), other);
    for (std::size_t i = 0; i < rasters_.size(); ++i) compare(rasters_[i], other, other.rasters_[i]);
    if (axis_.control.repeat != other.axis_.control.repeat)
      document_.fail_at(
          key_, fmt::format("the reference {}, expected the same as that of axis {}, with which it scans",
                            axis_.control.repeat ? "repeats" : "does not repeat", other.axis_.wire.name));
    if (axis_.control.repeat && !are_same(reference_.pass_s(), other.reference_.pass_s()))
      fail("", "seconds of a pass", reference_.pass_s(), other.reference_.pass_s(), other);
  }

 private:
  static constexpr double rounding = 1.0 + 1e-9;
  static bool are_same(double a, double b) { return std::abs(a - b) <= 1e-9 * (1.0 + std::abs(a)); }

  const controller::Raster& raster(std::size_t segment) const {
    return std::get<controller::Raster>(axis_.control.setpoint[segment].shape);
  }

  template <class Value>
  [[noreturn]] void fail(const std::string& place, const char* what, Value here, Value there,
                         const ScanAxis& other) const {
    document_.fail_at(key_ + place, fmt::format("{} is {}, expected {} as on axis {}, with which it scans",
                                                what, here, there, other.axis_.wire.name));
  }

  void compare(std::size_t segment, const ScanAxis& other, std::size_t other_segment) const {
    const controller::Raster& here = raster(segment);
    const controller::Raster& there = other.raster(other_segment);
    const std::string place = fmt::format("[{}]", segment);
    const auto same = [&](const char* key, auto a, auto b) {
      if (a != b) fail(fmt::format("{}.{}", place, key), key, a, b, other);
    };
    same("line_rate_Hz", here.line_rate_Hz, there.line_rate_Hz);
    same("lines", here.lines, there.lines);
    same("return_lines", here.return_lines, there.return_lines);
    same("frames", here.frames, there.frames);
    same("pixels", here.pixels, there.pixels);
    same("both_directions", here.both_directions, there.both_directions);
    if (!here.both_directions) same("flyback_percent", here.flyback_percent, there.flyback_percent);
    same("turnaround_percent", here.turnaround_percent, there.turnaround_percent);
    const double begins_s = reference_.begins_s(segment) + axis_.control.setpoint.front().transition_s;
    const double others_s =
        other.reference_.begins_s(other_segment) + other.axis_.control.setpoint.front().transition_s;
    if (!are_same(begins_s, others_s))
      fail(place + ".transition_s", "the time from the start to the scan in s", begins_s, others_s, other);
  }

  const Document& document_;
  const AxisConfig& axis_;
  std::string key_;
  controller::Trajectory reference_;
  std::vector<std::size_t> rasters_;  ///< indices of segments
};

}  // namespace

void check_scans(const Document& document, const Config& config) {
  std::vector<ScanAxis> scanning;
  for (std::size_t i = 0; i < config.axes.size(); ++i)
    if (std::ranges::any_of(config.axes[i].control.setpoint, is_raster))
      scanning.emplace_back(document, config, i);
  if (scanning.size() < 2) return;
  for (const ScanAxis& axis : scanning) {
    axis.check_first_way();
    axis.compare_with(scanning.front());
  }
}

}  // namespace hystcan::config
