#include "can/dbc/database.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <span>
#include <string>

#include "tests/can/dbc/refusal.h"
#include "tests/support/refusal.h"

namespace hystcan::can::database_test {
namespace {

using dbc_refusal::refusal;

/// A message of eight bytes whose signals are the given lines.
std::string message(const std::string& signals) { return "BO_ 385 Status: 8 Amp\n" + signals + "\n"; }

constexpr const char* typical = R"(VERSION "7.1"

NS_ :
	NS_DESC_
	CM_
	BA_DEF_
	BA_
	VAL_
	SIG_VALTYPE_
	BO_TX_BU_

BS_: 500000 : 1,2

BU_: Controller Amp
	Sensor

VAL_TABLE_ OnOff 1 "on" 0 "off" ;

BO_ 385 Status: 8 Amp
 SG_ Output : 0|32@1- (1e-06,-0.5) [-1000|1.5E3] "V" Controller,Sensor
 SG_ Level M : 39|8@0+ (0.25,+40) [0|0] "%" Vector__XXX
 SG_ Fast m3 : 40|16@1+ (1,0) [0|0] ""
 SG_ Slow m12M : 40|16@1- (1,0) [0|0] "" Controller

BO_ 2566843902 Long: 64 Vector__XXX
 SG_ Ratio : 0|32@1- (1,0) [0|0] "" Controller
 SG_ Exact : 448|64@1- (1,0) [0|0] "" Controller

BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX
 SG_ Stray : 0|8@1+ (1,0) [0|0] "" Vector__XXX

BO_TX_BU_ 385 : Amp,Sensor;
EV_ Temperature: 0 [-40|125] "C" 20 1 DUMMY_NODE_VECTOR0 Vector__XXX;
ENVVAR_DATA_ Blob: 5;
CM_ "whole file; with a semicolon";
CM_ BU_ Amp "the amplifier";
CM_ BO_ 385 "status of the \"amplifier\",
on two lines";
CM_ SG_ 385 Output "measured";
CM_ SG_ 3221225472 Stray "ignored";
CM_ EV_ Temperature "ignored";
BA_DEF_ BO_  "GenMsgCycleTime" INT 0 65535;
BA_DEF_DEF_  "GenMsgCycleTime" 0;
BA_ "GenMsgCycleTime" BO_ 385 10;
BA_ "Note" "semi;colon and \"quotes\"";
BA_DEF_REL_ BU_SG_REL_  "GenSigTimeoutTime" INT 0 65535;
VAL_ 385 Level 0 "empty" -1 "broken" 255 "full" ;
VAL_ Temperature 1 "warm" ;
SIG_GROUP_ 385 Both 1 : Output Level;
SG_MUL_VAL_ 385 Slow Level 12-12;
SIG_VALTYPE_ 2566843902 Ratio : 1;
SIG_VALTYPE_ 2566843902 Exact 2;
)";

TEST(Dbc, ReadsATypicalFile) {
  const Database database = parse_dbc(typical, "lab.dbc");
  EXPECT_EQ(database.warnings, std::vector<std::string>{"lab.dbc:45:6: attribute 'Note' is not defined"});
  ASSERT_EQ(database.messages.size(), 2U);

  const Message& status = *database.find("Status");
  EXPECT_EQ(status.id, 0x181U);
  EXPECT_FALSE(status.extended);
  EXPECT_EQ(status.length, 8);
  EXPECT_EQ(status.sender, "Amp");
  ASSERT_EQ(status.signals.size(), 4U);

  const Signal& output = *status.find("Output");
  EXPECT_EQ(output.start_bit, 0);
  EXPECT_EQ(output.length, 32);
  EXPECT_EQ(output.byte_order, ByteOrder::little_endian);
  EXPECT_TRUE(output.is_signed);
  EXPECT_EQ(output.scale, 1e-6) << "to the last bit";
  EXPECT_EQ(output.offset, -0.5);
  EXPECT_EQ(output.minimum, -1000.0);
  EXPECT_EQ(output.maximum, 1500.0);
  EXPECT_EQ(output.unit, "V");
  EXPECT_EQ(output.value_type, ValueType::integer);

  const Signal& level = *status.find("Level");
  EXPECT_EQ(level.byte_order, ByteOrder::big_endian);
  EXPECT_FALSE(level.is_signed);
  EXPECT_EQ(level.offset, 40.0);
  EXPECT_EQ(level.values, (std::map<std::int64_t, std::string>{{0, "empty"}, {-1, "broken"}, {255, "full"}}));
  EXPECT_EQ(status.find("Absent"), nullptr);
  EXPECT_EQ(database.find("Absent"), nullptr);
}

TEST(Dbc, ReadsMultiplexing) {
  const Database database = parse_dbc(typical, "lab.dbc");
  const Message& status = *database.find("Status");
  const auto multiplexing = [&](const char* name) { return status.find(name)->multiplexing; };
  EXPECT_FALSE(multiplexing("Output").is_switch);
  EXPECT_EQ(multiplexing("Output").present_at, std::nullopt);
  EXPECT_TRUE(multiplexing("Level").is_switch);
  EXPECT_EQ(multiplexing("Fast").present_at, 3U);
  EXPECT_FALSE(multiplexing("Fast").is_switch);
  EXPECT_EQ(multiplexing("Slow").present_at, 12U);
  EXPECT_TRUE(multiplexing("Slow").is_switch);
}

TEST(Dbc, ReadsTheValueTypesOfIeeeSignals) {
  const Database database = parse_dbc(typical, "lab.dbc");
  EXPECT_EQ(database.find("Long")->find("Ratio")->value_type, ValueType::float32);
  EXPECT_EQ(database.find("Long")->find("Exact")->value_type, ValueType::float64);
}

TEST(Dbc, ReadsDosLineEndsTabsAByteOrderMarkAndLatin1) {
  const Database database = parse_dbc(
      "\xEF\xBB\xBFVERSION \"\"\r\n\r\nBU_:\tAmp\r\n\r\nBO_ 1\tA: 1 Amp\r\n\tSG_ "
      "S:0|8@1+(1,0)[0|0]\"\xB0\x43\"Amp\r\n"
      "CM_ BO_ 1 \"\xFC\xE4\r\n\";\r\nVAL_ 1 S 0 \"\xFC\xE4\";\r\n",
      "lab.dbc");
  EXPECT_EQ(database.find("A")->find("S")->unit, "\xC2\xB0\x43") << "in UTF-8";
  EXPECT_EQ(database.find("A")->find("S")->values.at(0), "\xC3\xBC\xC3\xA4");
  EXPECT_EQ(refusal("VERSION \"\"\r\n\r\n\tBO_ x"),
            "lab.dbc:3:6: found 'x', expected the identifier of a message");
}

TEST(DbcError, NamesThePlaceTheFoundTextAndTheExpectedText) {
  EXPECT_EQ(refusal(message(" SG_ Position : 0 SG")),
            "lab.dbc:2:19: found 'SG', expected '|' in the bit position of signal Position");
  EXPECT_EQ(refusal(message(" SG_ Position : 0|32@2- (1,0) [0|0] \"um\" A")),
            "lab.dbc:2:22: found '2', expected 0 (big-endian) or 1 (little-endian) as the byte order of "
            "signal Position");
  EXPECT_EQ(refusal(message(" SG_ Position : 0|32@1- (nan,0) [0|0] \"um\" A")),
            "lab.dbc:2:26: found 'nan', expected a scale of signal Position that a double can hold");
  EXPECT_EQ(
      refusal(message(" SG_ Position : 0|32@1- (1,0) [0|0] \"um A\n SG_ B : 32|8@1+ (1,0) [0|0] \"V\" A")),
      "lab.dbc:2:37: found a text over several lines, expected the unit of signal Position in one line");
  EXPECT_EQ(refusal("BO_ 385 Status 8 Amp\n"),
            "lab.dbc:1:16: found '8', expected ':' after the name of message Status");
  EXPECT_EQ(refusal("VERSION \"\"\n\nBO 385 Status: 8 Amp\n"),
            "lab.dbc:3:1: found 'BO', expected a section of a DBC, such as BO_, CM_ or VAL_");
  EXPECT_EQ(refusal(message("CM_ BO_ 385 \"never ends;\n")),
            "lab.dbc:2:13: found a string without an end, expected a text in quotes");
  EXPECT_EQ(refusal(message("CM_ BO_ 385")),
            "lab.dbc:3:1: found the end of the file, expected a text in quotes");
  EXPECT_EQ(refusal("\x01\x02"),
            "lab.dbc:1:1: found byte 0x01, expected a DBC, which begins with VERSION, NS_, BS_, BU_ or BO_");
}

TEST(DbcError, RefusesATextThatIsNotADbc) {
  EXPECT_EQ(refusal(""),
            "lab.dbc:1:1: found the end of the file, expected a DBC, which begins with VERSION, NS_, BS_, "
            "BU_ or BO_");
  EXPECT_EQ(refusal("[hysteresis]\n"),
            "lab.dbc:1:1: found '[', expected a DBC, which begins with VERSION, NS_, BS_, BU_ or BO_");
}

TEST(DbcError, RefusesNumbersOutsideTheirRange) {
  EXPECT_EQ(refusal(message(" SG_ S : 0|65536@1+ (1,0) [0|0] \"\" A")),
            "lab.dbc:2:12: found '65536', expected a length of signal S from 0 to 65535");
  EXPECT_EQ(refusal(message(" SG_ S : 0|8@1+ (1e999,0) [0|0] \"\" A")),
            "lab.dbc:2:18: found '1e999', expected a scale of signal S that a double can hold");
  EXPECT_EQ(refusal(message(" SG_ S mM3 : 0|8@1+ (1,0) [0|0] \"\" A")),
            "lab.dbc:2:8: found 'mM3', expected M, or m with a number, or ':' after the name of signal S");
  EXPECT_EQ(refusal("BO_ 1 A: 65536 X\n"),
            "lab.dbc:1:10: found '65536', expected a length of message A in bytes from 0 to 65535");
  EXPECT_EQ(
      refusal("BO_ 1610612736 A: 8 X\n"),
      "lab.dbc:1:5: found '1610612736', expected an identifier of 11 bits, or of 29 bits with bit 31 set");
  EXPECT_EQ(refusal("BO_ 4294967296 A: 8 X\n"),
            "lab.dbc:1:5: found '4294967296', expected the identifier of a message from 0 to 4294967295");
}

TEST(DbcError, IsTheFirstOneInTheText) {
  EXPECT_EQ(
      refusal("BO_ 536870912 A: 1 X\nBO_ 1: 1 X\n"),
      "lab.dbc:1:5: found '536870912', expected an identifier of 11 bits, or of 29 bits with bit 31 set");
}

TEST(DbcError, RefusesASignalWithoutAMessage) {
  EXPECT_EQ(refusal(" SG_ S : 0|8@1+ (1,0) [0|0] \"\" A"),
            "lab.dbc:1:6: found signal S, expected a message (BO_) before it");
  EXPECT_EQ(refusal("BO_ 1 A: 8 X\nCM_ \"\";\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" A"),
            "lab.dbc:3:6: found signal S, expected a message (BO_) before it");
}

TEST(DbcError, CountsLinesWithAnyLineEnd) {
  for (const std::string end : {"\n", "\r\n", "\r"})
    EXPECT_EQ(refusal("VERSION \"\"" + end + end + "BO_ x"),
              "lab.dbc:3:5: found 'x', expected the identifier of a message");
}

TEST(DbcError, NamesTheReasonWhyAFileCannotBeRead) {
  const auto refused = [](const std::filesystem::path& file) -> std::string {
    return support::refusal_of([&] { load_dbc(file); });
  };
  EXPECT_EQ(refused("/absent/x.dbc"), "/absent/x.dbc: cannot be read: No such file or directory");
  EXPECT_EQ(refused(HYSTCAN_SOURCE_DIR "/config"),
            HYSTCAN_SOURCE_DIR "/config: cannot be read: Is a directory");
}

struct Expected {
  const char* name;
  std::uint32_t id;
  int length;
};
constexpr Expected one_axis[] = {
    {"Nmt", 0x000, 2},           {"Sync", 0x080, 1},          {"ControllerHeartbeat", 0x77F, 1},
    {"XAmpEmcy", 0x081, 8},      {"XSensorEmcy", 0x082, 8},   {"XAmpStatus", 0x181, 8},
    {"XSensorSample", 0x182, 8}, {"XAmpCommand", 0x201, 8},   {"XControllerStatus", 0x281, 8},
    {"XSetpoint", 0x301, 8},     {"XAmpHeartbeat", 0x701, 1}, {"XSensorHeartbeat", 0x702, 1}};
constexpr Expected second_axis[] = {
    {"YAmpEmcy", 0x083, 8},         {"YSensorEmcy", 0x084, 8},       {"YAmpStatus", 0x183, 8},
    {"YSensorSample", 0x184, 8},    {"YAmpCommand", 0x203, 8},       {"YAmpHeartbeat", 0x703, 1},
    {"YSensorHeartbeat", 0x704, 1}, {"YControllerStatus", 0x283, 8}, {"YSetpoint", 0x303, 8}};

constexpr Expected scan_markers[] = {{"XScanMarker", 0x381, 8}, {"YScanMarker", 0x383, 8}};

void expect_messages(const Database& database, std::span<const Expected> messages) {
  for (const auto& [name, id, length] : messages) {
    const Message* found = database.find(name);
    ASSERT_NE(found, nullptr) << name;
    EXPECT_EQ(found->id, id) << name;
    EXPECT_EQ(found->length, length) << name;
    EXPECT_FALSE(found->extended) << name;
  }
}

void expect_signal(const Message& message, const char* name, int start_bit, int length) {
  const Signal* signal = message.find(name);
  ASSERT_NE(signal, nullptr) << message.name << '.' << name;
  EXPECT_EQ(signal->start_bit, start_bit) << message.name << '.' << name;
  EXPECT_EQ(signal->length, length) << message.name << '.' << name;
}

TEST(ShippedDbc, HasTheMessagesOfTheProtocolTable) {
  const Database piezo = load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  expect_messages(piezo, one_axis);
  expect_messages(piezo, second_axis);
  expect_messages(piezo, scan_markers);
  EXPECT_EQ(piezo.messages.size(), std::size(one_axis) + std::size(second_axis) + std::size(scan_markers));
  const Database galfenol = load_dbc(HYSTCAN_SOURCE_DIR "/config/galfenol.dbc");
  expect_messages(galfenol, one_axis);
  EXPECT_EQ(galfenol.messages.size(), std::size(one_axis));
}

TEST(ShippedDbc, HasTheSignalPlacesOfTheScanMarker) {
  const Database database = load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  for (const char* name : {"XScanMarker", "YScanMarker"}) {
    const Message& marker = *database.find(name);
    expect_signal(marker, "Line", 0, 16);
    expect_signal(marker, "Frame", 16, 16);
    expect_signal(marker, "SyncCounter", 32, 8);
    expect_signal(marker, "Counter", 48, 4);
    expect_signal(marker, "Crc", 56, 8);
  }
}

TEST(ShippedDbc, HasTheSignalPlacesOfTheProtocolTable) {
  for (const auto& [file, unit] : {std::pair{"hystcan.dbc", "V"}, std::pair{"galfenol.dbc", "A"}}) {
    const Database database = load_dbc(std::string(HYSTCAN_SOURCE_DIR "/config/") + file);
    const Message& command = *database.find("XAmpCommand");
    const Message& status = *database.find("XAmpStatus");
    const Message& sample = *database.find("XSensorSample");
    const Message& axis_status = *database.find("XControllerStatus");
    const Message& setpoint = *database.find("XSetpoint");
    for (const Message* message : {&command, &status, &sample, &axis_status, &setpoint}) {
      expect_signal(*message, "Counter", 48, 4);
      expect_signal(*message, "Crc", 56, 8);
      const Signal& value = message->signals.front();
      EXPECT_TRUE(value.is_signed);
      EXPECT_EQ(value.scale, 1e-6);
      EXPECT_EQ(value.unit, message == &command || message == &status ? unit : "um");
    }
    expect_signal(command, "Setpoint", 0, 32);
    expect_signal(command, "Enable", 32, 1);
    expect_signal(command, "ClearFault", 33, 1);
    expect_signal(command, "SyncCounter", 40, 8);
    expect_signal(status, "Output", 0, 32);
    expect_signal(status, "State", 32, 8);
    expect_signal(status, "Fault", 40, 8);
    expect_signal(sample, "Position", 0, 32);
    expect_signal(sample, "SyncCounter", 32, 8);
    expect_signal(sample, "Status", 40, 8);
    expect_signal(axis_status, "FollowingError", 0, 32);
    expect_signal(axis_status, "State", 32, 8);
    expect_signal(axis_status, "Cause", 40, 8);
    expect_signal(axis_status, "InPosition", 52, 1);
    expect_signal(axis_status, "Limited", 53, 1);
    expect_signal(axis_status, "ReferenceFinished", 54, 1);
    expect_signal(setpoint, "Position", 0, 32);
    expect_signal(setpoint, "Mode", 32, 8);
    EXPECT_EQ(status.find("State")->values.at(3), "fault");
    EXPECT_EQ(database.find("Nmt")->find("Command")->values.at(129), "reset node");
    EXPECT_EQ(database.find("XAmpHeartbeat")->find("State")->values.at(127), "pre-operational");
  }
}

}  // namespace
}  // namespace hystcan::can::database_test
