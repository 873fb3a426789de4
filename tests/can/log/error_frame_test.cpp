#include "can/log/error_frame.h"
#include "tests/support/shows.h"

#include <gtest/gtest.h>

#include <array>

namespace hystcan::can::error_frame_test {
namespace {

using Payload = std::array<std::uint8_t, 8>;

// The values are from linux/can/error.h and part of the ABI.
ErrorReport report_of(std::uint32_t classes, Payload payload = {}) {
  Frame frame{.id = classes, .kind = FrameKind::error, .length = 8};
  std::copy(payload.begin(), payload.end(), frame.data.begin());
  return interpret(frame);
}
std::optional<BusState> state_in(std::uint32_t classes, std::uint8_t controller = 0) {
  return report_of(classes, {0, controller}).state;
}

TEST(ErrorFrame, GivesTheStateOfTheController) {
  EXPECT_EQ(state_in(0x040), BusState::bus_off);
  EXPECT_EQ(state_in(0x100), BusState::active) << "restarted";
  EXPECT_EQ(state_in(0x004, 0x04), BusState::warning) << "receive errors";
  EXPECT_EQ(state_in(0x004, 0x08), BusState::warning) << "transmit errors";
  EXPECT_EQ(state_in(0x004, 0x10), BusState::passive) << "receive errors";
  EXPECT_EQ(state_in(0x004, 0x20), BusState::passive) << "transmit errors";
  EXPECT_EQ(state_in(0x004, 0x24), BusState::passive) << "the worse of two";
  EXPECT_EQ(state_in(0x004, 0x40), BusState::active);
}

TEST(ErrorFrame, GivesNoStateForAnErrorOfTheBus) {
  EXPECT_EQ(state_in(0x020), std::nullopt) << "no acknowledgement";
  EXPECT_EQ(state_in(0x088, 0x20), std::nullopt) << "protocol error on the bus";
  EXPECT_EQ(state_in(0x004, 0x01), std::nullopt) << "receive overflow";
}

TEST(ErrorFrame, GivesTheErrorCountersOfItsLastTwoBytes) {
  const ErrorCounters counters{.transmit = 136, .receive = 7};
  EXPECT_EQ(report_of(0x204, {0, 0x20, 0, 0, 0, 0, 136, 7}).error_counters, counters);
  EXPECT_EQ(report_of(0x200).error_counters, (ErrorCounters{})) << "both are given, and are 0";
  EXPECT_EQ(report_of(0x004, {0, 0x20, 0, 0, 0, 0, 136, 7}).error_counters, counters) << "an older driver";
  EXPECT_EQ(report_of(0x004, {0, 0x20}).error_counters, std::nullopt) << "a driver that gives none";
  EXPECT_EQ(report_of(0x008, {0, 0, 0, 0, 0, 0, 136, 7}).error_counters, std::nullopt)
      << "in this class the driver may use bytes 6 and 7";
}

TEST(ErrorFrame, CountsForEachOfItsCauses) {
  shows("S-163");
  BusCounters counters;
  count(report_of(0x020), counters);
  count(report_of(0x002), counters);
  count(report_of(0x088, {0, 0, 0x04}), counters);
  count(report_of(0x088, {0, 0, 0x80, 0x19}), counters);
  count(report_of(0x004, {0, 0x01}), counters);
  count(report_of(0x004, {0, 0x02}), counters);
  count(report_of(0x010, {0, 0, 0, 0, 0x04}), counters);
  count(report_of(0x100), counters);
  count(report_of(0x02A), counters);
  EXPECT_EQ(counters.error_frames, 9U);
  EXPECT_EQ(counters.not_acknowledged, 3U)
      << "by its class, by the place in the frame, and together with others";
  EXPECT_EQ(counters.arbitration_lost, 2U);
  EXPECT_EQ(counters.protocol_errors, 2U);
  EXPECT_EQ(counters.controller_overflows, 2U);
  EXPECT_EQ(counters.transceiver_errors, 1U);
  EXPECT_EQ(counters.restarts, 1U);
  EXPECT_EQ(counters.warnings + counters.passives + counters.bus_offs, 0U);
}

TEST(BusStates, CountEachTimeTheyAreEntered) {
  BusCounters counters;
  for (const BusState state : {BusState::warning, BusState::passive, BusState::bus_off, BusState::down,
                               BusState::active, BusState::warning}) {
    counters.count_entry(state);
  }
  EXPECT_EQ(counters.warnings, 2U);
  EXPECT_EQ(counters.passives, 1U);
  EXPECT_EQ(counters.bus_offs, 1U);
}

TEST(BusStates, HaveTheNamesOfTheLog) {
  EXPECT_EQ(to_string(BusState::active), "active");
  EXPECT_EQ(to_string(BusState::bus_off), "bus-off");
  EXPECT_EQ(to_string(BusState::down), "down");
}

}  // namespace
}  // namespace hystcan::can::error_frame_test
