// What an axis lacks before it is driven: the order of it, its bounds, and what is named together.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "controller/control/arming.h"

namespace hystcan::controller::arming_lack_test {
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

LackSet lacks_with_output(double output) {
  AxisInput input = complete();
  input.health.amplifier_output = output;
  return lacks_of(input, gate_above_zero);
}

TEST(ArmingLack, IsTheFirstOfThoseThatAreMissing) {
  AxisInput input;
  input.health.amplifier_fault = true;
  input.health.amplifier_moves = true;
  const auto expect = [&](Lack lack) {
    EXPECT_EQ(lacks_of(input, gate_above_zero).first(), lack) << to_string(lack);
  };
  expect(Lack::sensor_heartbeat);
  input.health.sensor_alive = true;
  expect(Lack::amplifier_heartbeat);
  input.health.amplifier_alive = true;
  expect(Lack::sensor_operational);
  input.health.sensor_operational = true;
  expect(Lack::amplifier_operational);
  input.health.amplifier_operational = true;
  expect(Lack::clear);
  input.health.amplifier_fault = false;
  expect(Lack::amplifier_ready);
  input.health.amplifier_ready = true;
  expect(Lack::amplifier_output);
  input.health.amplifier_output = 10.0;
  expect(Lack::amplifier_rest);
  input.health.amplifier_moves = false;
  expect(Lack::sample);
  input.position_um = 0.0;
  expect(Lack::nothing);
}

TEST(ArmingLack, IsNotAnOutputThatIsBeyondTheGateByTheErrorOfItsReading) {
  EXPECT_EQ(lacks_with_output(9.0), Lack::nothing);
  EXPECT_EQ(lacks_with_output(111.0), Lack::nothing);
}

TEST(ArmingLack, IsAnOutputThatIsFurtherBeyondTheGate) {
  EXPECT_EQ(lacks_with_output(8.999), Lack::amplifier_output);
  EXPECT_EQ(lacks_with_output(111.001), Lack::amplifier_output);
  EXPECT_EQ(lacks_with_output(std::numeric_limits<double>::quiet_NaN()), Lack::amplifier_output);
}

using Lacks = std::vector<Lack>;

TEST(ArmingLacks, AreTheFirstOfEachNode) {
  AxisInput input;
  input.health.amplifier_fault = true;
  input.health.amplifier_moves = true;
  const auto expect = [&](const Lacks& lacks) {
    EXPECT_EQ(lacks_of(input, gate_above_zero).members(), lacks);
  };
  expect({Lack::sensor_heartbeat, Lack::amplifier_heartbeat});
  input.health.sensor_alive = true;
  input.health.amplifier_alive = true;
  expect({Lack::sensor_operational, Lack::amplifier_operational});
  input.health.sensor_operational = true;
  input.health.amplifier_operational = true;
  expect({Lack::clear, Lack::sample});
  input.health.amplifier_fault = false;
  expect({Lack::amplifier_ready, Lack::sample});
}

TEST(ArmingLacks, AreOutputAndRestOfAnAmplifierThatIsReady) {
  AxisInput input = complete();
  input.health.amplifier_output = 8.0;
  input.health.amplifier_moves = true;
  EXPECT_EQ(lacks_of(input, gate_above_zero).members(),
            (Lacks{Lack::amplifier_output, Lack::amplifier_rest}));
}

TEST(LackSet, HasRoomForEachLackAndNoneForNothing) {
  for (std::size_t i = 1; i < lack_count; ++i) {
    const auto lack = static_cast<Lack>(i);
    EXPECT_EQ(LackSet(lack).first(), lack);
    EXPECT_EQ(LackSet(lack).members(), Lacks{lack});
  }
  EXPECT_TRUE(LackSet(Lack::nothing).empty());
  EXPECT_EQ(LackSet().first(), Lack::nothing);
}

}  // namespace
}  // namespace hystcan::controller::arming_lack_test
