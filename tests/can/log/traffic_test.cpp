// The counts of `monitor`, and the text of an error frame.
#include "can/log/traffic.h"

#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <algorithm>
#include <cmath>

#include "can/log/error_frame.h"
#include "can/protocol/layout.h"

namespace hystcan::can::traffic_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

const Database& shipped() {
  static const Database database = load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  return database;
}

/// A SYNC with this counter.
LoggedFrame sync(microseconds time, std::uint8_t counter) {
  LoggedFrame logged;
  logged.time = time;
  logged.frame.id = 0x080;
  logged.frame.length = 1;
  logged.frame.data[0] = counter;
  return logged;
}

LoggedFrame command() {
  LoggedFrame logged;  // the frame in docs/protocol/frames.md: 201#4E61BC00010703D9
  logged.frame = {.id = 0x201, .extended = false, .kind = FrameKind::data, .length = 8, .data = {}};
  const std::uint8_t bytes[] = {0x4E, 0x61, 0xBC, 0x00, 0x01, 0x07, 0x03, 0xD9};
  std::copy(std::begin(bytes), std::end(bytes), logged.frame.data.begin());
  return logged;
}

LoggedFrame error(std::uint32_t classes, std::uint8_t controller, std::uint8_t transmit,
                  std::uint8_t receive) {
  LoggedFrame logged;
  logged.frame = {.id = classes, .extended = false, .kind = FrameKind::error, .length = 8, .data = {}};
  logged.frame.data[1] = controller;
  logged.frame.data[6] = transmit;
  logged.frame.data[7] = receive;
  return logged;
}

std::uint64_t rejected(const Traffic& traffic, std::uint32_t id, Rejection cause) {
  return traffic.messages().at({false, id}).rejected[static_cast<std::size_t>(cause)];
}

TEST(Traffic, GivesFramesPerPeriodAsRateAndDeviationOfIntervalsAsJitter) {
  Traffic traffic(shipped());
  // The intervals are 9, 11, 9, 11, ... ms, fifty of each.
  microseconds time{0};
  for (int i = 0; i <= 100; ++i) {
    traffic.add(sync(time, 1));
    time += i % 2 == 0 ? milliseconds{9} : milliseconds{11};
  }
  traffic.end_period(std::chrono::seconds{1});
  const MessageTraffic& of_sync = traffic.messages().at({false, 0x080});
  EXPECT_DOUBLE_EQ(of_sync.rate_Hz, 101.0);
  ASSERT_TRUE(of_sync.jitter_ms);
  EXPECT_NEAR(*of_sync.jitter_ms, std::sqrt(100.0 / 99.0), 1e-9)
      << "1 ms, as the deviation of a sample of 100";
  traffic.end_period(std::chrono::seconds{1});
  EXPECT_EQ(traffic.messages().at({false, 0x080}).rate_Hz, 0.0);
  EXPECT_FALSE(traffic.messages().at({false, 0x080}).jitter_ms);
  EXPECT_EQ(traffic.messages().at({false, 0x080}).count, 101U);
}

TEST(Traffic, CountsEveryRejectionByItsCause) {
  Traffic traffic(shipped());
  LoggedFrame frame = command();
  traffic.add(frame);
  traffic.add(frame);  // the counter has its first value again
  frame.frame.data[0] ^= 1;
  traffic.add(frame);
  frame.frame.length = 7;
  traffic.add(frame);
  frame = command();
  frame.frame.extended = true;
  traffic.add(frame);
  frame = command();
  frame.frame.kind = FrameKind::remote;
  traffic.add(frame);
  for (const Rejection cause : {Rejection::repeated_counter, Rejection::wrong_crc, Rejection::wrong_length,
                                Rejection::extended_id, Rejection::wrong_kind})
    EXPECT_EQ(rejected(traffic, 0x201, cause), 1U) << to_string(cause);
  EXPECT_EQ(traffic.messages().at({false, 0x201}).count, 6U);
  EXPECT_EQ(traffic.messages().at({false, 0x201}).newest->frame, command().frame);
}

TEST(Traffic, ChecksKindAndLengthOfAnUnprotectedMessage) {
  Traffic traffic(shipped());
  LoggedFrame frame = sync(microseconds{0}, 1);
  frame.frame.length = 2;
  traffic.add(frame);
  frame.frame.kind = FrameKind::remote;
  traffic.add(frame);
  EXPECT_EQ(rejected(traffic, 0x080, Rejection::wrong_length), 1U);
  EXPECT_EQ(rejected(traffic, 0x080, Rejection::wrong_kind), 1U);
}

// The lab's command in docs/protocol/own_frames.md, 18EF1001#4F133F2D. Counter and CRC have their own names
// and places; only the configuration defines the polynomial and the data id of the CRC.
TEST(Traffic, ChecksAConfiguredMessageWithAnExtendedIdentifier) {
  const Database lab = load_dbc(HYSTCAN_SOURCE_DIR "/config/lab_amplifier.dbc");
  const MessageMap map{.message = "AmpSet",
                       .counter = "Cnt",
                       .crc = "Crc",
                       .polynomial = Crc::autosar_8h2f,
                       .data_id = {.kind = DataId::Kind::number, .number = 0x10A1}};
  Traffic traffic(lab, {{"AmpSet", protection_of(*lab.find("AmpSet"), map)}});
  LoggedFrame frame;
  frame.frame = {.id = 0x18EF1001, .extended = true, .length = 4, .data = {0x4F, 0x13, 0x3F, 0x2D}};
  traffic.add(frame);
  traffic.add(frame);
  frame.frame.data[2] ^= 1;
  traffic.add(frame);
  frame.frame.length = 5;
  traffic.add(frame);
  const MessageTraffic& counted = traffic.messages().at({true, 0x18EF1001});
  EXPECT_EQ(counted.count, 4U);
  for (const Rejection cause : {Rejection::repeated_counter, Rejection::wrong_crc, Rejection::wrong_length})
    EXPECT_EQ(counted.rejected[static_cast<std::size_t>(cause)], 1U) << to_string(cause);
}

/// The SYNC message has ten bytes here, 12 on the wire.
TEST(Traffic, ExpectsALongMessageAsFdFrameWithALengthOfCanFd) {
  for (const bool configured : {false, true}) {
    Database database = shipped();
    const auto sync_message = std::ranges::find(database.messages, "Sync", &Message::name);
    sync_message->length = 10;
    sync_message->fd = true;
    Traffic traffic(database, configured ? Protections{{"Sync", Protection{}}} : Protections{});
    LoggedFrame frame = sync(microseconds{0}, 1);
    frame.frame.kind = FrameKind::fd;
    frame.frame.length = 12;
    traffic.add(frame);
    EXPECT_EQ(traffic.messages().at({false, 0x080}).newest->frame, frame.frame) << "accepted";
    frame.frame.length = 16;
    traffic.add(frame);
    EXPECT_EQ(rejected(traffic, 0x080, Rejection::wrong_length), 1U);
  }
}

TEST(Traffic, CountsAnUnknownIdentifierWithoutAMessage) {
  Traffic traffic(shipped());
  LoggedFrame frame = sync(microseconds{0}, 1);
  frame.frame.extended = true;
  traffic.add(frame);
  EXPECT_EQ(traffic.messages().at({true, 0x080}).message, nullptr);
  EXPECT_EQ(traffic.messages().at({true, 0x080}).count, 1U);
}

TEST(Traffic, ReadsTheStateOfTheBusFromErrorFrames) {
  Traffic traffic(shipped());
  EXPECT_FALSE(traffic.state());
  traffic.add(error(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE, 128, 3));
  EXPECT_EQ(traffic.state(), BusState::passive);
  EXPECT_EQ(traffic.error_counters(), (ErrorCounters{128, 3}));
  traffic.add(error(CAN_ERR_BUSOFF, 0, 0, 0));
  EXPECT_EQ(traffic.state(), BusState::bus_off);
  LoggedFrame lost;
  lost.frame = drop_notice(3);
  traffic.add(lost);
  EXPECT_EQ(traffic.error_frames(), 2U) << "a loss of the recorder is not an error of the bus";
}

TEST(ErrorWords, NameEveryCauseWithItsNumbers) {
  EXPECT_EQ(describe_error(error(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING, 96, 0).frame),
            "transmit errors: warning, error counters: transmit 96, receive 0");
  LoggedFrame stuff = error(CAN_ERR_PROT | CAN_ERR_BUSERROR, 0, 0, 0);
  stuff.frame.data[2] = CAN_ERR_PROT_STUFF;
  stuff.frame.data[3] = CAN_ERR_PROT_LOC_CRC_SEQ;
  EXPECT_EQ(describe_error(stuff.frame), "bus error, stuff error, at place 8");
  LoggedFrame lost = error(CAN_ERR_LOSTARB | CAN_ERR_ACK, 0, 0, 0);
  lost.frame.data[0] = 12;
  EXPECT_EQ(error_causes(lost.frame), (std::vector<std::string>{"arbitration lost", "not acknowledged"}));
  EXPECT_EQ(describe_error(drop_notice(5)), "frames lost by the recorder: 5");
  EXPECT_EQ(describe_error(error(0, 0, 0, 0).frame), "error of an unknown class");
}

}  // namespace
}  // namespace hystcan::can::traffic_test
