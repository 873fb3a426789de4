// Compares three signals of one motion: the true motion of the stage, the samples that its sensor sent, and
// those that the controller received. An error of sign or scale in one of them differs from the two others.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::truth_test {
namespace {

constexpr double wire_step_um = 1e-6;  // docs/protocol/frames.md

struct Cycle {
  twin::Truth truth;
  controller::AxisReport report;
};

/// Returns all cycles of axis x with a sample, over the whole reference of the shipped piezo stage.
std::vector<Cycle> cycles() {
  std::optional<twin::Truth> newest;
  std::vector<Cycle> all;
  rehearsal::run_once(
      support::shipped("piezo.toml"), 0.1,
      [&](const controller::CycleRecord& record) {
        if (record.axis != 0 || record.report.sample_missing || !newest) return;
        all.push_back({*newest, record.report});
        newest.reset();
      },
      [&](const twin::Truth& truth) {
        if (truth.axis == 0) newest = truth;
      });
  return all;
}

/// Least-squares fit, with the RMS of its residual:
///
///   y = offset + slope x
struct Line {
  double slope = 0.0;
  double rms = 0.0;
};

template <class X, class Y>
Line fit(const std::vector<Cycle>& cycles, X x, Y y) {
  const auto n = static_cast<double>(cycles.size());
  double mean_x = 0.0, mean_y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  for (const Cycle& one : cycles) {
    mean_x += x(one) / n;
    mean_y += y(one) / n;
  }
  for (const Cycle& one : cycles) {
    const double dx = x(one) - mean_x;
    const double dy = y(one) - mean_y;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
  }
  const double slope = xy / xx;
  return {slope, std::sqrt(std::abs(yy - slope * xy) / n)};
}

TEST(Truth, EqualsTheMeasuredAndReceivedPosition) {
  shows("S-073");
  const std::vector<Cycle> all = cycles();
  ASSERT_GT(all.size(), 1000u);
  double worst_um = 0.0;
  for (const Cycle& one : all)
    worst_um = std::max(worst_um, std::abs(one.report.position_um - one.truth.measured_um));
  EXPECT_LE(worst_um, 0.51 * wire_step_um) << "they differ only by the rounding of the wire";

  // The noise is 0.3 nm and the resolution 0.1 nm. 1 % is ten standard deviations of an estimate from 10 000
  // samples of a Gaussian; there are some thousands of samples.
  const Line sensor = fit(
      all, [](const Cycle& c) { return c.truth.position_um; },
      [](const Cycle& c) { return c.truth.measured_um; });
  const double expected_um = std::hypot(0.0003, 0.0001 / std::sqrt(12.0));
  EXPECT_NEAR(sensor.slope, 1.0, 1e-5);
  EXPECT_NEAR(sensor.rms, expected_um, 0.1 * expected_um);
}

}  // namespace
}  // namespace hystcan::truth_test
