#include "controller/control/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hystcan::controller::statistics_test {
namespace {

AxisReport report(double error_um, double shape_time_s, bool in_transition = false) {
  AxisReport result;
  result.state = AxisState::tracking;
  result.reference_um = 10.0 + error_um;
  result.position_um = 10.0;
  result.point = {.segment = 1,
                  .in_transition = in_transition,
                  .shape_time_s = shape_time_s,
                  .ideal_um = result.reference_um};
  return result;
}

TEST(TrackingStatistics, CountsOnlyTheSettledSamplesOfASegment) {
  TrackingStatistics statistics(2, 0.1);
  statistics.add(report(100.0, 0.05));       // not settled
  statistics.add(report(100.0, 0.0, true));  // in the transition to the segment
  statistics.add(report(3.0, 0.1));
  statistics.add(report(-4.0, 0.2));
  AxisReport lost = report(100.0, 0.3);
  lost.sample_missing = true;
  statistics.add(lost);

  EXPECT_EQ(statistics.segments()[0].samples, 0u);
  EXPECT_EQ(statistics.segments()[1].samples, 2u);
  EXPECT_DOUBLE_EQ(statistics.segments()[1].rms_um(), std::sqrt(12.5));
  EXPECT_DOUBLE_EQ(statistics.total().max_um, 4.0);
}

TEST(TrackingStatistics, AlsoHaveTheErrorAgainstTheIdealReference) {
  TrackingStatistics statistics(2, 0.1);
  AxisReport turning = report(1.0, 0.2);
  turning.point.ideal_um = turning.reference_um + 2.0;
  statistics.add(turning);
  EXPECT_DOUBLE_EQ(statistics.total().max_um, 1.0);
  EXPECT_DOUBLE_EQ(statistics.against_ideal()[1].max_um, 3.0);
  EXPECT_DOUBLE_EQ(statistics.total_against_ideal().rms_um(), 3.0);
}

}  // namespace
}  // namespace hystcan::controller::statistics_test
