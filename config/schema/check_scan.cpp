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

/// An axis whose reference has at least one raster. All axes of a scan must have equal rasters.
class ScanAxis : Checked {
 public:
  ScanAxis(const Checked& checked, std::size_t index)
      : Checked(checked), axis_(config.axes[index]), reference_(controller::reference_of(axis_.control)) {
    const std::vector<controller::Segment>& segments = axis_.control.setpoint;
    for (std::size_t i = 0; i < segments.size(); ++i)
      if (is_raster(segments[i])) rasters_.push_back(i);
  }

  /// Checks the transition from the start position of the axis to the first segment: transition_s must be
  /// long enough for the farthest start position within the reference limits. Otherwise the transition would
  /// take longer than transition_s, and the axis would begin the scan later than the other axes.
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
      fail(first.transition_s,
           "transition_s is {:g}, expected at least {:.3g}: within the reference limits, the "
           "axis needs this time from its farthest start position, and the axes of a scan start together",
           first.transition_s, least_s);
  }

  /// Checks that the rasters of the axis `other` have the same lines at the same times.
  void compare_with(const ScanAxis& other) const {
    if (rasters_.size() != other.rasters_.size())
      differ(list(), "rasters", rasters_.size(), other.rasters_.size(), other);
    for (std::size_t i = 0; i < rasters_.size(); ++i) compare(rasters_[i], other, other.rasters_[i]);
    if (axis_.control.repeat != other.axis_.control.repeat)
      document.fail_at(
          list(), fmt::format("the reference {}, expected the same as on axis {} of the same scan",
                              axis_.control.repeat ? "repeats" : "does not repeat", other.axis_.wire.name));
    if (axis_.control.repeat && !are_same(reference_.pass_s(), other.reference_.pass_s()))
      differ(list(), "seconds of a pass", reference_.pass_s(), other.reference_.pass_s(), other);
  }

 private:
  static constexpr double rounding = 1.0 + 1e-9;
  static bool are_same(double a, double b) { return std::abs(a - b) <= 1e-9 * (1.0 + std::abs(a)); }

  const controller::Raster& raster(std::size_t segment) const {
    return std::get<controller::Raster>(axis_.control.setpoint[segment].shape);
  }

  template <class Value>
  [[noreturn]] void differ(const std::string& path, std::string_view what, Value here, Value there,
                           const ScanAxis& other) const {
    document.fail_at(path, fmt::format("{} is {}, expected {} as on axis {} of the same scan", what, here,
                                       there, other.axis_.wire.name));
  }
  /// Returns the path of the axis's list of segments in the configuration: "axis[0].control.setpoint".
  std::string list() const {
    const std::string first = path_of(config, axis_.control.setpoint.front());
    return first.substr(0, first.rfind('['));
  }

  void compare(std::size_t segment, const ScanAxis& other, std::size_t other_segment) const {
    const controller::Raster& here = raster(segment);
    const controller::Raster& there = other.raster(other_segment);
    const auto same = [&](const auto& a, const auto& b) {
      if (a != b) differ(path_of(config, a), key_of(axis_, a), a, b, other);
    };
    same(here.line_rate_Hz, there.line_rate_Hz);
    same(here.lines, there.lines);
    same(here.return_lines, there.return_lines);
    same(here.frames, there.frames);
    same(here.pixels, there.pixels);
    same(here.both_directions, there.both_directions);
    if (!here.both_directions) same(here.flyback_percent, there.flyback_percent);
    same(here.turnaround_percent, there.turnaround_percent);
    const double begins_s = reference_.begins_s(segment) + axis_.control.setpoint.front().transition_s;
    const double others_s =
        other.reference_.begins_s(other_segment) + other.axis_.control.setpoint.front().transition_s;
    if (!are_same(begins_s, others_s))
      differ(path_of(config, axis_.control.setpoint[segment].transition_s),
             "the time in s from the start to the scan", begins_s, others_s, other);
  }

  const AxisConfig& axis_;
  controller::Trajectory reference_;
  std::vector<std::size_t> rasters_;  ///< indices of the segments that are rasters
};

}  // namespace

void check_scans(const Checked& checked) {
  const Config& config = checked.config;
  std::vector<ScanAxis> scanning;
  for (std::size_t i = 0; i < config.axes.size(); ++i)
    if (std::ranges::any_of(config.axes[i].control.setpoint, is_raster)) scanning.emplace_back(checked, i);
  if (scanning.size() < 2) return;
  for (const ScanAxis& axis : scanning) {
    axis.check_first_way();
    axis.compare_with(scanning.front());
  }
}

}  // namespace hystcan::config
