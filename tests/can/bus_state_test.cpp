#include "can/bus_state.h"

#include <gtest/gtest.h>

namespace hystcan::can {
namespace {

Frame error_frame(std::uint32_t classes, std::uint8_t controller = 0) {
  Frame frame{.id = classes, .kind = FrameKind::error, .length = 8};
  frame.data[1] = controller;
  return frame;
}

// Values of linux/can/error.h, which are ABI.
TEST(ErrorFrame, TellsTheStateOfTheController) {
  EXPECT_EQ(state_told_by(error_frame(0x040)), BusState::bus_off);
  EXPECT_EQ(state_told_by(error_frame(0x100)), BusState::active) << "restarted";
  EXPECT_EQ(state_told_by(error_frame(0x004, 0x04)), BusState::warning) << "receive errors";
  EXPECT_EQ(state_told_by(error_frame(0x004, 0x08)), BusState::warning) << "transmit errors";
  EXPECT_EQ(state_told_by(error_frame(0x004, 0x10)), BusState::passive) << "receive errors";
  EXPECT_EQ(state_told_by(error_frame(0x004, 0x20)), BusState::passive) << "transmit errors";
  EXPECT_EQ(state_told_by(error_frame(0x004, 0x24)), BusState::passive) << "the worse of two";
  EXPECT_EQ(state_told_by(error_frame(0x004, 0x40)), BusState::active);
}

TEST(ErrorFrame, OfAnotherKindTellsNoState) {
  EXPECT_EQ(state_told_by(error_frame(0x020)), std::nullopt) << "no acknowledgement";
  EXPECT_EQ(state_told_by(error_frame(0x088, 0x20)), std::nullopt) << "protocol error on the bus";
  EXPECT_EQ(state_told_by(error_frame(0x004, 0x01)), std::nullopt) << "receive overflow";
}

TEST(BusStateNames, AreThoseOfTheLog) {
  EXPECT_EQ(to_string(BusState::active), "active");
  EXPECT_EQ(to_string(BusState::bus_off), "bus-off");
  EXPECT_EQ(to_string(BusState::down), "down");
}

}  // namespace
}  // namespace hystcan::can
