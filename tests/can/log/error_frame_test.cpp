#include "can/log/error_frame.h"

#include <gtest/gtest.h>

#include <array>

namespace hystcan::can {
namespace {

using Payload = std::array<std::uint8_t, 8>;

// Values of linux/can/error.h, which are ABI.
ErrorReport told_by(std::uint32_t classes, Payload payload = {}) {
  Frame frame{.id = classes, .kind = FrameKind::error, .length = 8};
  std::copy(payload.begin(), payload.end(), frame.data.begin());
  return interpret(frame);
}
std::optional<BusState> state_told_by(std::uint32_t classes, std::uint8_t controller = 0) {
  return told_by(classes, {0, controller}).state;
}

TEST(ErrorFrame, TellsTheStateOfTheController) {
  EXPECT_EQ(state_told_by(0x040), BusState::bus_off);
  EXPECT_EQ(state_told_by(0x100), BusState::active) << "restarted";
  EXPECT_EQ(state_told_by(0x004, 0x04), BusState::warning) << "receive errors";
  EXPECT_EQ(state_told_by(0x004, 0x08), BusState::warning) << "transmit errors";
  EXPECT_EQ(state_told_by(0x004, 0x10), BusState::passive) << "receive errors";
  EXPECT_EQ(state_told_by(0x004, 0x20), BusState::passive) << "transmit errors";
  EXPECT_EQ(state_told_by(0x004, 0x24), BusState::passive) << "the worse of two";
  EXPECT_EQ(state_told_by(0x004, 0x40), BusState::active);
}

TEST(ErrorFrame, OfAnotherKindTellsNoState) {
  EXPECT_EQ(state_told_by(0x020), std::nullopt) << "no acknowledgement";
  EXPECT_EQ(state_told_by(0x088, 0x20), std::nullopt) << "protocol error on the bus";
  EXPECT_EQ(state_told_by(0x004, 0x01), std::nullopt) << "receive overflow";
}

TEST(ErrorFrame, TellsTheErrorCountersInItsLastTwoBytes) {
  const ErrorCounters counters{.transmit = 136, .receive = 7};
  EXPECT_EQ(told_by(0x204, {0, 0x20, 0, 0, 0, 0, 136, 7}).error_counters, counters);
  EXPECT_EQ(told_by(0x200).error_counters, (ErrorCounters{})) << "both are 0, and said to be";
  EXPECT_EQ(told_by(0x004, {0, 0x20, 0, 0, 0, 0, 136, 7}).error_counters, counters) << "an older driver";
  EXPECT_EQ(told_by(0x004, {0, 0x20}).error_counters, std::nullopt) << "a driver that gives none";
  EXPECT_EQ(told_by(0x008, {0, 0, 0, 0, 0, 0, 136, 7}).error_counters, std::nullopt)
      << "bytes 6 and 7 are the driver's own there";
}

TEST(ErrorFrame, IsCountedUnderEachThingItTells) {
  BusCounters counters;
  count(told_by(0x020), counters);
  count(told_by(0x002), counters);
  count(told_by(0x088, {0, 0, 0x04}), counters);
  count(told_by(0x088, {0, 0, 0x80, 0x19}), counters);
  count(told_by(0x004, {0, 0x01}), counters);
  count(told_by(0x004, {0, 0x02}), counters);
  count(told_by(0x010, {0, 0, 0, 0, 0x04}), counters);
  count(told_by(0x100), counters);
  count(told_by(0x02A), counters);
  EXPECT_EQ(counters.error_frames, 9U);
  EXPECT_EQ(counters.not_acknowledged, 3U) << "by class, by the place in the frame, and among others";
  EXPECT_EQ(counters.arbitration_lost, 2U);
  EXPECT_EQ(counters.protocol_errors, 2U);
  EXPECT_EQ(counters.controller_overflows, 2U);
  EXPECT_EQ(counters.transceiver_errors, 1U);
  EXPECT_EQ(counters.restarts, 1U);
  EXPECT_EQ(counters.warnings + counters.passives + counters.bus_offs, 0U);
}

TEST(BusStates, AreCountedAsTheyAreEntered) {
  BusCounters counters;
  for (const BusState state : {BusState::warning, BusState::passive, BusState::bus_off, BusState::down,
                               BusState::active, BusState::warning}) {
    count_entry(state, counters);
  }
  EXPECT_EQ(counters.warnings, 2U);
  EXPECT_EQ(counters.passives, 1U);
  EXPECT_EQ(counters.bus_offs, 1U);
}

TEST(BusStates, AreNamedAsInTheLog) {
  EXPECT_EQ(to_string(BusState::active), "active");
  EXPECT_EQ(to_string(BusState::bus_off), "bus-off");
  EXPECT_EQ(to_string(BusState::down), "down");
}

}  // namespace
}  // namespace hystcan::can
