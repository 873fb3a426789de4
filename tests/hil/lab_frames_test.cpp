// A laboratory's own frames between the two processes: 29-bit identifiers, nodes set up by SDO, CAN FD.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/hil/live_bench.h"

namespace hystcan::lab_frames_test {
namespace {

using hil::FreshVcan;
using hil::json;
using hil::LiveBench;
using hil::Process;

using Log = std::vector<std::string>;

/// The frames of the log that begin with one of the prefixes.
Log with(const Log& log, const std::vector<std::string>& prefixes) {
  Log found;
  std::ranges::copy_if(log, std::back_inserter(found), [&](const std::string& frame) {
    return std::ranges::any_of(prefixes,
                               [&](const std::string& prefix) { return frame.starts_with(prefix); });
  });
  return found;
}

std::size_t count(const Log& log, const std::string& prefix) { return with(log, {prefix}).size(); }

/// CRC-8H2F of AUTOSAR's specification of CRC routines, computed bit by bit.
unsigned crc8_h2f(const std::string& bytes) {
  unsigned crc = 0xFF;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = ((crc & 0x80U) != 0 ? (crc << 1U) ^ 0x2FU : crc << 1U) & 0xFFU;
  }
  return crc ^ 0xFFU;
}

std::string from_hex(const std::string& digits) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
    bytes.push_back(static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16)));
  return bytes;
}

struct VcanLabFrames : testing::Test {
  std::string config() const { return (folder / "lab_amplifier.toml").string(); }

  /// The frames that candump received while the axis tracked its reference.
  Log frames_of_tracking() {
    LiveBench bench({"vcan0", "vcan0"}, config());
    bench.start_controller({"--duration", "1.5", "--json"});
    EXPECT_EQ(bench.controller->wait(), 0) << bench.controller->err();
    const json result = json::parse(bench.controller->out());
    const json& axis = result.at("axes")[0];
    EXPECT_EQ(axis.at("fault"), "none");
    EXPECT_LT(axis.at("rms_percent"), 1.0) << axis.dump(2);
    EXPECT_EQ(result.at("bus").at("send_refused"), 0);
    for (const auto& [cause, frames] : axis.at("rejected_samples").items()) EXPECT_EQ(frames, 0) << cause;
    return bench.frames();
  }
  /// Twin and controller both end at once with this message.
  void both_refuse(const std::string& message) {
    for (const char* command : {"twin", "controller"}) {
      Process process({HYSTCAN_PROGRAM, command, config(), "--interface", "vcan0"});
      EXPECT_EQ(process.wait(), 1) << command;
      EXPECT_NE(process.err().find(message), std::string::npos) << process.err();
    }
  }

  support::ShippedCopy folder;
  FreshVcan fresh;
};

const char* const setup_by_sdo =
    "[[axis.amplifier_setup]]\nindex = 0x2001\nsubindex = 5\nvalue = 0x1234\nbytes = 2\n\n"
    "[[axis.sensor_setup]]\nindex = 0x2100\nsubindex = 0\nvalue = 7\nbytes = 1\n\n"
    "[axis.frames.command]";

TEST_F(VcanLabFrames, TrackOnAClassicalInterfaceOnceTheirNodesAreSetUp) {
  FreshVcan::make(16);
  folder.edit("lab_amplifier.toml", "[axis.frames.command]", setup_by_sdo);
  const Log log = frames_of_tracking();
  const auto until_started = [&](const std::vector<std::string>& prefixes, const std::string& start) {
    Log found = with(log, prefixes);
    found.erase(std::ranges::find(found, start), found.end());
    return found;
  };
  EXPECT_EQ(
      with(until_started({"601#", "581#", "000#"}, "000#0101"), {"601#", "581#"}),
      (Log{"601#2B01200534120000", "581#6001200500000000", "601#4001200500000000", "581#4B01200534120000"}));
  EXPECT_EQ(
      with(until_started({"602#", "582#", "000#"}, "000#0102"), {"602#", "582#"}),
      (Log{"602#2F00210007000000", "582#6000210000000000", "602#4000210000000000", "582#4F00210007000000"}));
  EXPECT_EQ(count(log, "601#"), 2U) << "the node is set up only once";

  EXPECT_GT(count(log, "18EF1001#"), 500U) << "AmpSet";
  EXPECT_GT(count(log, "18EE1002#"), 500U) << "SensPos";
  EXPECT_GT(count(log, "18EE1001#"), 50U) << "AmpGet, every tenth cycle";
  EXPECT_TRUE(with(log, {"201#", "181#", "182#", "00000201#"}).empty());
  ASSERT_EQ(crc8_h2f("123456789"), 0xDFU) << "the check value";
  for (const std::string& frame : with(log, {"18EF1001#"})) {
    const std::string payload = from_hex(frame.substr(9));
    ASSERT_EQ(payload.size(), 4U) << frame;
    ASSERT_EQ(crc8_h2f("\xA1\x10" + payload.substr(1)), static_cast<std::uint8_t>(payload[0])) << frame;
  }
}

struct VcanLabFdFrames : VcanLabFrames {
  void SetUp() override {
    folder.edit("lab_amplifier.dbc", "AmpSet: 4 Host", "AmpSet: 18 Host");
    folder.edit("lab_amplifier.dbc", "SensPos: 4 Sensor", "SensPos: 18 Sensor");
  }
};

TEST_F(VcanLabFdFrames, AreRefusedByAClassicalInterfaceAndTrackOnOneThatTakesThem) {
  FreshVcan::make(16);
  both_refuse(
      "interface vcan0 takes no CAN FD frames, expected one that does for AmpSet, SensPos; take it down "
      "and set: ip link set vcan0 mtu 72");
  EXPECT_TRUE(hil::shell("ip link set vcan0 down && ip link set vcan0 mtu 72 && ip link set vcan0 up"));
  const Log log = frames_of_tracking();
  for (const char* id : {"18EF1001##", "18EE1002##"}) {
    const Log frames = with(log, {id});
    EXPECT_GT(frames.size(), 500U) << id;
    for (const std::string& frame : frames)
      ASSERT_EQ(frame.size(), 8U + 2U + 1U + 40U)
          << frame << ": 18 bytes are sent as 20, after a digit of flags";
  }
  EXPECT_GT(count(log, "18EE1001#"), 50U) << "AmpGet has 4 bytes and stays classical";
  EXPECT_EQ(count(log, "18EE1001##"), 0U);
}

}  // namespace
}  // namespace hystcan::lab_frames_test
