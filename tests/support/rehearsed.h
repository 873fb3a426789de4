// Makes a rehearsal from a configuration and evaluates its tracking.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "app/live/rehearsal_setup.h"
#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/count_allocations.h"

namespace hystcan::support {

constexpr auto ignore = [](const controller::CycleRecord&) {};

inline rehearsal::Setup setup_of(const config::Config& config) { return app::rehearsal_setup(config); }

/// Returns a shipped configuration with some values replaced by `settings`.
inline rehearsal::Setup shipped(const std::string& name, const std::vector<config::Setting>& settings = {}) {
  return setup_of(config::load(HYSTCAN_SOURCE_DIR "/config/" + name, settings));
}

/// Returns the RMS error of axis 0 in its first segment, the triangle of the shipped configurations, in % of
/// stroke.
inline double triangle_percent(const rehearsal::Outcome& outcome) {
  return 100.0 * outcome.axes[0].statistics.segments()[0].rms_um() / outcome.axes[0].stroke_um;
}

/// Returns the allocations in one second of tracking, from 2 s after the start on. Requires
/// count_allocations.cpp.
inline std::uint64_t allocations_while_tracking(const rehearsal::Setup& setup) {
  rehearsal::Rehearsal rehearsal(setup, ignore);
  rehearsal.start();
  rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(rehearsal.controller().axis(0).state(), controller::AxisState::tracking);
  const std::uint64_t before = allocations_so_far();
  rehearsal.run_for(std::chrono::seconds(1));
  return allocations_so_far() - before;
}

}  // namespace hystcan::support
