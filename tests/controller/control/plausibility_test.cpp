// The check of the start-up's ramps beside a slow sensor. tests/safety/ramp_check_test.cpp has the check
// in an axis.
#include "controller/control/plausibility.h"

#include <gtest/gtest.h>

#include <numbers>

#include "controller/control/supervisor.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::plausibility_test {
namespace {

// 30 ms that are stated, at 2 V in a cycle: the position rises for 20 cycles more while the drive falls.
TEST(RampCheckTest, AcceptsASlowSensorThatStillRisesBehindTheTurn) {
  constexpr double tau_s = 0.03;
  Course course(support::piezo_model(), {.sensor_bandwidth_Hz = 1.0 / (2.0 * std::numbers::pi * tau_s)});
  RampCheck check(
      {.drive_range = 100.0, .stroke_um = 30.0, .ramp_um_per_s = 600.0, .mode_rad_per_s = 3e4, .doubt = 0.3});
  course.restart(0.0);
  AxisInput input;
  input.dt_s = input.cycle_s = 1e-3;
  input.position_um = course.position_um();
  check.rest(course, 0.0, input);
  double drive = 0.0;
  for (int cycle = 0; cycle < 80; ++cycle) {
    drive += cycle < 50 ? 2.0 : -2.0;
    course.step(drive, input.dt_s, input.cycle_s);
    *input.position_um += (course.position_um() - *input.position_um) * input.dt_s / (input.dt_s + tau_s);
    ASSERT_TRUE(check.step(course, drive, input)) << drive << " V, cycle " << cycle;
  }
}

}  // namespace
}  // namespace hystcan::controller::plausibility_test
