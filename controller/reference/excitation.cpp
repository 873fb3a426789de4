#include "controller/reference/excitation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace hystcan::controller {
namespace {

/// Maximum duration in s, longer than any measurement. A longer excitation is a typing error and would fill
/// the disk.
constexpr double longest_s = 1e6;

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

void expect(bool sound, const std::string& what, const std::string& expected) {
  if (!sound) throw std::invalid_argument("excitation: " + what + ", expected " + expected);
}

void expect_positive(const char* name, double value) {
  expect(std::isfinite(value) && value > 0.0, std::string(name) + " is " + number(value), "a number > 0");
}

void expect_count(const char* name, unsigned value, unsigned least) {
  expect(value >= least && value <= Excitation::most_turns,
         std::string(name) + " is " + std::to_string(value),
         std::to_string(least) + " to " + std::to_string(Excitation::most_turns));
}

void expect_finite(const char* name, double value) {
  expect(std::isfinite(value), std::string(name) + " is " + number(value), "a finite number");
}

void validate(const Excitation::Hysteresis& h) {
  expect_finite("low", h.low);
  expect_finite("high", h.high);
  expect(h.low < h.high, "low is " + number(h.low), "less than high, " + number(h.high));
  expect_positive("slew", h.slew_per_s);
  expect(std::isfinite(h.rest_s) && h.rest_s >= 0.0, "rest is " + number(h.rest_s), "seconds >= 0");
  expect_count("the number of loops", h.loops, 1);
  expect_count("the number of levels", h.levels, 0);
}

void validate(const Excitation::Steps& s) {
  expect_finite("centre", s.centre);
  expect_positive("amplitude", s.amplitude);
  expect_positive("period", s.period_s);
  expect_count("the number of cycles", s.cycles, 1);
}

void validate(const Excitation::Chirp& c) {
  expect_finite("centre", c.centre);
  expect_positive("amplitude", c.amplitude);
  expect_positive("the first frequency", c.from_Hz);
  expect_positive("the last frequency", c.to_Hz);
  expect_positive("duration", c.duration_s);
}

}  // namespace

std::string_view name_of(const Excitation::Config& config) {
  static constexpr std::array<std::string_view, std::variant_size_v<Excitation::Config>> names{
      "hysteresis", "step", "chirp"};
  return names[config.index()];
}

double loop_s(const Excitation::Hysteresis& h) { return 2.0 * ((h.high - h.low) / h.slew_per_s + h.rest_s); }

std::vector<double> turning_points(const Excitation::Hysteresis& h) {
  const double span = h.high - h.low;
  const double middle = h.low + span / 2.0;
  const double parts = h.levels + 1.0;
  std::vector<double> points{h.low};
  for (unsigned i = 0; i < h.loops; ++i) points.insert(points.end(), {h.high, h.low});
  if (h.levels == 0) return points;
  for (unsigned k = 1; k <= h.levels; ++k) {
    const double half = (1.0 - k / parts) * span / 2.0;
    points.insert(points.end(), {middle + half, middle - half});
  }
  points.push_back(h.high);
  for (unsigned j = h.levels; j >= 1; --j) points.insert(points.end(), {h.low + span * j / parts, h.high});
  points.push_back(h.low);
  for (unsigned j = 1; j <= h.levels; ++j) points.insert(points.end(), {h.low + span * j / parts, h.low});
  return points;
}

Excitation::Excitation(const Config& config) : config_(config) {
  std::visit(
      [this](const auto& c) {
        validate(c);
        add_knots(c);
      },
      config_);
  expect(length_s_ <= longest_s, "the drive lasts " + number(length_s_) + " s",
         "at most " + number(longest_s));
}

void Excitation::hold(double drive, double duration_s) {
  knots_.push_back({length_s_, drive});
  length_s_ += duration_s;
  knots_.push_back({length_s_, drive});
}

void Excitation::add_knots(const Hysteresis& h) {
  for (const double drive : turning_points(h)) {
    if (!knots_.empty()) length_s_ += std::abs(drive - knots_.back().drive) / h.slew_per_s;
    hold(drive, h.rest_s);
  }
}

void Excitation::add_knots(const Steps& s) {
  const double half_s = s.period_s / 2.0;
  hold(s.centre, half_s);
  for (unsigned i = 0; i < s.cycles; ++i) {
    hold(s.centre + s.amplitude, half_s);
    hold(s.centre - s.amplitude, half_s);
  }
  hold(s.centre, half_s);
}

void Excitation::add_knots(const Chirp& c) { length_s_ = c.duration_s; }

double Excitation::at(double t_s) const {
  t_s = std::clamp(t_s, 0.0, length_s_);
  if (const auto* c = std::get_if<Chirp>(&config_)) {
    const double cycles = t_s * (c->from_Hz + (c->to_Hz - c->from_Hz) * t_s / (2.0 * c->duration_s));
    return c->centre + c->amplitude * std::sin(2.0 * std::numbers::pi * cycles);
  }
  const auto after = std::ranges::upper_bound(knots_, t_s, {}, &Knot::time_s);
  if (after == knots_.end()) return knots_.back().drive;
  const Knot& from = *(after - 1);
  return std::lerp(from.drive, after->drive, (t_s - from.time_s) / (after->time_s - from.time_s));
}

model::Interval Excitation::range() const {
  if (const auto* c = std::get_if<Chirp>(&config_))
    return {c->centre - c->amplitude, c->centre + c->amplitude};
  const auto [least, most] = std::ranges::minmax(knots_, {}, &Knot::drive);
  return {least.drive, most.drive};
}

double Excitation::steepest_per_s() const {
  if (const auto* h = std::get_if<Hysteresis>(&config_)) return h->slew_per_s;
  if (const auto* c = std::get_if<Chirp>(&config_))
    return 2.0 * std::numbers::pi * std::max(c->from_Hz, c->to_Hz) * c->amplitude;
  return 0.0;
}

void refuse_beyond(const model::Interval& range, double slew_per_s, const Excitation& excitation) {
  const model::Interval drive = excitation.range();
  expect(drive.lo >= range.lo && drive.hi <= range.hi,
         "the drive ranges from " + number(drive.lo) + " to " + number(drive.hi),
         "a drive within drive_min and drive_max, " + number(range.lo) + " and " + number(range.hi));
  expect(excitation.steepest_per_s() <= slew_per_s,
         "the drive changes by " + number(excitation.steepest_per_s()) + " per s",
         "at most slew_per_s, " + number(slew_per_s));
}

}  // namespace hystcan::controller
