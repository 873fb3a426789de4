// The missing conditions of an axis before it is driven: their order, their bounds, and the ones that are
// reported together. Then the report.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "controller/control/arming.h"
#include "tests/controller/control/ideal_stage.h"

namespace hystcan::controller::arming_blocks_test {
namespace {

/// Its range is 100, and the error of a reading is 1.
constexpr Gate::Config gate_above_zero{.drive_min = 10.0, .drive_max = 110.0};

AxisInput complete() {
  return {.position_um = 0.0,
          .health = {.sensor_alive = true,
                     .sensor_operational = true,
                     .amplifier_alive = true,
                     .amplifier_operational = true,
                     .amplifier_ready = true,
                     .amplifier_output = 10.0}};
}

ArmingBlocks blocks_with_output(double output) {
  AxisInput input = complete();
  input.health.amplifier_output = output;
  return arming_blocks_of(input, gate_above_zero);
}

TEST(ArmingBlocks, ReportTheFirstMissingCondition) {
  AxisInput input;
  input.health.amplifier_fault = true;
  input.health.amplifier_moves = true;
  const auto expect = [&](ArmingBlock block) {
    EXPECT_EQ(arming_blocks_of(input, gate_above_zero).first(), block) << to_string(block);
  };
  expect(ArmingBlock::sensor_heartbeat);
  input.health.sensor_alive = true;
  expect(ArmingBlock::amplifier_heartbeat);
  input.health.amplifier_alive = true;
  expect(ArmingBlock::sensor_operational);
  input.health.sensor_operational = true;
  expect(ArmingBlock::amplifier_operational);
  input.health.amplifier_operational = true;
  expect(ArmingBlock::clear);
  input.health.amplifier_fault = false;
  expect(ArmingBlock::amplifier_ready);
  input.health.amplifier_ready = true;
  expect(ArmingBlock::amplifier_output);
  input.health.amplifier_output = 10.0;
  expect(ArmingBlock::amplifier_rest);
  input.health.amplifier_moves = false;
  expect(ArmingBlock::sample);
  input.position_um = 0.0;
  expect(ArmingBlock::nothing);
}

TEST(ArmingBlocks, AllowAnOutputBeyondTheGateWithinItsReadingError) {
  EXPECT_EQ(blocks_with_output(9.0), ArmingBlock::nothing);
  EXPECT_EQ(blocks_with_output(111.0), ArmingBlock::nothing);
}

TEST(ArmingBlocks, ReportAnOutputFurtherBeyondTheGate) {
  EXPECT_EQ(blocks_with_output(8.999), ArmingBlock::amplifier_output);
  EXPECT_EQ(blocks_with_output(111.001), ArmingBlock::amplifier_output);
  EXPECT_EQ(blocks_with_output(std::numeric_limits<double>::quiet_NaN()), ArmingBlock::amplifier_output);
}

using Blocks = std::vector<ArmingBlock>;

TEST(ArmingBlocks, ReportTheFirstConditionOfEachNode) {
  AxisInput input;
  input.health.amplifier_fault = true;
  input.health.amplifier_moves = true;
  const auto expect = [&](const Blocks& blocks) {
    EXPECT_EQ(arming_blocks_of(input, gate_above_zero).members(), blocks);
  };
  expect({ArmingBlock::sensor_heartbeat, ArmingBlock::amplifier_heartbeat});
  input.health.sensor_alive = true;
  input.health.amplifier_alive = true;
  expect({ArmingBlock::sensor_operational, ArmingBlock::amplifier_operational});
  input.health.sensor_operational = true;
  input.health.amplifier_operational = true;
  expect({ArmingBlock::clear, ArmingBlock::sample});
  input.health.amplifier_fault = false;
  expect({ArmingBlock::amplifier_ready, ArmingBlock::sample});
}

TEST(ArmingBlocks, ReportOutputAndRestOfAReadyAmplifier) {
  AxisInput input = complete();
  input.health.amplifier_output = 8.0;
  input.health.amplifier_moves = true;
  EXPECT_EQ(arming_blocks_of(input, gate_above_zero).members(),
            (Blocks{ArmingBlock::amplifier_output, ArmingBlock::amplifier_rest}));
}

TEST(ArmingBlocks, HoldEachConditionExceptNothing) {
  for (std::size_t i = 1; i < arming_block_count; ++i) {
    const auto block = static_cast<ArmingBlock>(i);
    EXPECT_EQ(ArmingBlocks(block).first(), block);
    EXPECT_EQ(ArmingBlocks(block).members(), Blocks{block});
  }
  EXPECT_TRUE(ArmingBlocks(ArmingBlock::nothing).empty());
  EXPECT_EQ(ArmingBlocks().first(), ArmingBlock::nothing);
}

TEST(ArmingReport, NamesMissingOtherAxes) {
  IdealStage stage;
  stage.axis.start(false);
  ASSERT_TRUE(stage.reaches(AxisState::ready));
  stage.cycle([](AxisInput& in) { in.tracking_since_s.reset(); });
  EXPECT_EQ(stage.axis.report().arming_blocks, ArmingBlock::other_axes);
  stage.cycle();
  EXPECT_EQ(stage.axis.report().arming_blocks, ArmingBlock::nothing);
}

TEST(ArmingReport, IsEmptyForAnOfflineAxis) {
  IdealStage stage;
  stage.axis.start(false);
  stage.cycle([](AxisInput& in) { in.health.sensor_alive = false; });
  ASSERT_EQ(stage.axis.report().arming_blocks, ArmingBlock::sensor_heartbeat);
  stage.axis.stop();
  stage.cycle();
  EXPECT_EQ(stage.axis.report().arming_blocks, ArmingBlock::nothing);
}

}  // namespace
}  // namespace hystcan::controller::arming_blocks_test
