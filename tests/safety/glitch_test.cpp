// A sensor that is off by 8 um for 10 ms, with limits of 5 um per cycle and 4 um of following error: the loop
// must not follow it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/fault_rig.h"
#include "tests/support/shows.h"

namespace hystcan::support::glitch_test {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;

struct Outcome {
  Cause cause = Cause::none;
  double drive_moved = 0.0;  ///< motion of the drive while the sample was off and the axis tracked
};

Outcome outcome_of(double offset_um, can::Duration lasts, can::Duration begins) {
  config::Config config = one_axis();
  config.axes[0].control.supervision.position_jump_um = 5.0;
  config.axes[0].control.following_error.error_um = 4.0;
  twin::FaultSpec spec = twin::fault_spec(twin::Fault::sensor_offset, "x");
  spec.value = offset_um;
  spec.begins = begins;
  spec.lasts = lasts;
  config.twin.faults = {spec};
  FaultRig rig(config);
  rig.start();
  EXPECT_TRUE(rig.tracks());
  rig.run_for(can::Time{begins} - rig.clock().now());
  const double reference_um = rig.axis().report().reference_um, drive = rig.axis().report().drive;
  Outcome outcome;
  for (can::Duration past{}; past < lasts + milliseconds(300); past += milliseconds(1)) {
    rig.run_for(milliseconds(1));
    if (rig.axis().state() != AxisState::tracking) break;
    // Motion that the reference alone requires: at least a fifth of a micrometre per volt.
    const double asked = std::abs(rig.axis().report().reference_um - reference_um) / 0.2;
    outcome.drive_moved = std::max(outcome.drive_moved, std::abs(rig.axis().report().drive - drive) - asked);
  }
  outcome.cause = rig.axis().fault().cause;
  return outcome;
}

TEST(Glitch, IsAJumpThatTheDriveDoesNotFollow) {
  shows("S-010, S-018");
  for (const double offset_um : {8.0, -8.0, 6.0})
    for (const int begins_ms : {1710, 1850, 1980, 2110}) {
      const Outcome outcome = outcome_of(offset_um, milliseconds(10), milliseconds(begins_ms));
      EXPECT_EQ(to_string(outcome.cause), "position jumped") << offset_um << " at " << begins_ms;
      EXPECT_LE(outcome.drive_moved, 1.0) << offset_um << " at " << begins_ms;
    }
}

TEST(Glitch, IsBridgedForTheAllowedMissingCycles) {
  shows("S-010");
  const Outcome outcome = outcome_of(8.0, milliseconds(3), milliseconds(1710));
  EXPECT_EQ(to_string(outcome.cause), "none");
  EXPECT_LE(outcome.drive_moved, 1.0);
}

}  // namespace
}  // namespace hystcan::support::glitch_test
