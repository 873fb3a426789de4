// A lab's own frames in the configuration: errors with their place, and missing functions.
#include "config/schema/frames.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string_view>

#include "config/schema/check.h"
#include "config/schema/config.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::frames_test {
namespace {

constexpr const char* file = "lab_amplifier.toml";

struct BadFrames {
  const char* name;
  const char* in;
  const char* what;
  const char* with;
  const char* at;       ///< text of the line that the error must name
  const char* message;  ///< text that the error must contain

  friend void PrintTo(const BadFrames& frames, std::ostream* out) { *out << frames.name; }
};

class InvalidFrames : public testing::TestWithParam<BadFrames> {};

TEST_P(InvalidFrames, AreRefusedAtTheirLine) {
  const BadFrames& bad = GetParam();
  const support::ShippedCopy shipped;
  shipped.edit(bad.in, bad.what, bad.with);
  const std::string refusal = support::refusal_of<std::runtime_error>([&] { load(shipped / file); });
  EXPECT_NE(refusal.find(bad.message), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("expected"), std::string::npos) << refusal;
  const std::string content = support::read_file(shipped / file);
  const auto line = 1 + std::count(content.begin(),
                                   content.begin() + static_cast<std::ptrdiff_t>(content.find(bad.at)), '\n');
  EXPECT_TRUE(refusal.starts_with((shipped / file).string() + ":" + std::to_string(line) + ":")) << refusal;
}

INSTANTIATE_TEST_SUITE_P(
    Frames, InvalidFrames,
    testing::Values(
        BadFrames{
            "NoSuchMessage", file, "\"AmpSet\"", "\"AmpSte\"", "message      = ",
            "no message AmpSte in lab_amplifier.dbc, expected a message for axis x; the most similar names: "
            "AmpSet"},
        BadFrames{
            "NoSuchSignal", file, "setpoint     = \"Volt\"", "setpoint     = \"volts\"", "setpoint     = ",
            "message AmpSet has no signal volts in lab_amplifier.dbc, expected a signal for axis x; the most "
            "similar names: Volt"},
        BadFrames{"NoSuchCounter", file, "\"Cnt\"", "\"Count\"", "counter      = ", "has no signal Count"},
        BadFrames{"UnknownRole", file, "enable       = ", "enabel       = ", "enabel", "unknown key enabel"},
        BadFrames{"NoSetpoint", file, "setpoint     = \"Volt\" ", "", "[axis.frames.command]",
                  "missing key setpoint"},
        BadFrames{"UnknownIntegrity", file, "\"counter+crc\"", "\"parity\"",
                  "integrity    =", "integrity is \"parity\""},
        BadFrames{"UnknownPolynomial", file, "\"CRC-8H2F\"", "\"CRC-32\"", "polynomial",
                  "polynomial is \"CRC-32\""},
        BadFrames{"NoDataId", file, "data_id      = 0x10A1", "", "[axis.frames.command]",
                  "missing key data_id"},
        BadFrames{"NoCrcCovers", file, "crc_covers", "# crc_covers", "[axis.frames.command]",
                  "missing key crc_covers"},
        BadFrames{"CrcWithoutUse", file, "integrity    = \"counter+crc\"", "integrity    = \"counter\"",
                  "crc          =", "unknown key crc"},
        BadFrames{"CrcNotAByte", file, "crc          = \"Crc\"", "crc          = \"On\"",
                  "crc          = ", "overlaps another"},
        BadFrames{"OneSignalForTwoRoles", file, "clear_fault  = \"Rst\"", "clear_fault  = \"On\"",
                  "enable       = ", "signal On of message AmpSet overlaps another"},
        BadFrames{"SyncCounterTooSmall", file, "clear_fault  = \"Rst\"", "sync_counter = \"Rst\"",
                  "sync_counter = ", "signal Rst of message AmpSet holds 0 to 1"},
        BadFrames{
            "AMultiplexedRole", "lab_amplifier.dbc", "SG_ On : 12|1@1+",
            "SG_ Page M : 14|2@1+ (1,0) [0|3] \"\"  Amp\n SG_ On m1 : 12|1@1+", "enable       = ",
            "signal On of message AmpSet is multiplexed in lab_amplifier.dbc, expected a signal that is in "
            "every frame"},
        BadFrames{"EnableInStepsOfTwo", "lab_amplifier.dbc", "SG_ On : 12|1@1+ (1,0) [0|1]",
                  "SG_ On : 12|1@1+ (2,0) [0|2]", "enable       = ",
                  "signal On of message AmpSet holds 0 to 2 in steps of 2 in lab_amplifier.dbc, "
                  "expected 0 and 1"},
        BadFrames{"PositionsBeyondTheSignal", "lab_amplifier.dbc", "SG_ Pos : 7|24@0- (0.1,0)",
                  "SG_ Pos : 7|16@0- (1,0)", "position_max_um    = 34.0",
                  "the positions -3..34 um do not fit signal Pos, expected within -32.768..32.767 um"},
        BadFrames{"StateThatDoesNotFit", file, "state_fault   = [64, 65]", "state_fault   = [64, 256]",
                  "state_fault   =", "256 does not fit signal St"},
        BadFrames{"NoValueForReady", file, "state_ready   = [16]", "state_ready   = []", "state_ready",
                  "no raw value of signal St is configured"},
        BadFrames{"StateNotANumber", file, "state_ready   = [16]", "state_ready   = [\"on\"]", "state_ready",
                  "state_ready is of type string"},
        BadFrames{"UnitOfAnotherQuantity", "lab_amplifier.dbc", "\"nm\"", "\"mA\"",
                  "position  =", "signal Pos of SensPos has the unit \"mA\""},
        BadFrames{"IdentifierOfCanOpen", "lab_amplifier.dbc", "BO_ 2565804033 AmpSet", "BO_ 1537 AmpSet",
                  "message      = ", "which the SDO request to node 1 uses"},
        BadFrames{"DriveBeyondTheSignal", file, "drive_max_V        = 100.0", "drive_max_V        = 115.0",
                  "drive_max_V        = 115.0", "does not fit signal Volt, expected within -20..111.07"}),
    [](const auto& test) { return test.param.name; });

TEST(LabFrames, AreReportedWithTheirMissingFunctions) {
  const Config config = load(HYSTCAN_SOURCE_DIR "/config/lab_amplifier.toml");
  const std::vector<std::string> lines = losses(config.axes[0].wire);
  const auto says = [&](const std::string& what) {
    return std::ranges::any_of(lines, [&](const std::string& line) { return line.starts_with(what); });
  };
  EXPECT_TRUE(says("command: no SyncCounter"));
  EXPECT_TRUE(says("status: no Fault"));
  EXPECT_TRUE(says("status: no CRC"));
  EXPECT_TRUE(says("sample: no SyncCounter"));
  EXPECT_TRUE(says("sample: no counter"));
  EXPECT_TRUE(says("sample: no CRC"));
  EXPECT_EQ(lines.size(), 6u);
}

TEST(StandardFrames, HaveAllFunctions) {
  const Config config = load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  EXPECT_TRUE(losses(config.axes[0].wire).empty());
  EXPECT_TRUE(fd_messages(config.axes[0].wire, config.database).empty());
}

TEST(DataBitRate, DecidesWhetherFramesOfCanFdSwitchTheBitRate) {
  const support::ShippedCopy shipped;
  const char* rate = "bitrate_bit_per_s = 1_000_000\n";
  shipped.edit("lab_amplifier.dbc", "BO_ 2565804033 AmpSet: 4", "BO_ 2565804033 AmpSet: 12");
  EXPECT_EQ(fd_messages(load(shipped / "lab_amplifier.toml").axes[0].wire,
                        load(shipped / "lab_amplifier.toml").database),
            (std::vector<std::string>{"AmpSet"}));
  EXPECT_FALSE(load(shipped / "lab_amplifier.toml").database.find("AmpSet")->bit_rate_switch);
  shipped.edit("lab_amplifier.toml", rate, std::string(rate) + "data_bitrate_bit_per_s = 5_000_000\n");
  const Config config = load(shipped / "lab_amplifier.toml");
  EXPECT_TRUE(config.database.find("AmpSet")->bit_rate_switch);
  EXPECT_EQ(config.bus.rates(), (can::BitRates{.nominal_bit_per_s = 1'000'000, .data_bit_per_s = 5'000'000}));
}

TEST(DataBitRate, IsRefusedBelowTheNominalOne) {
  const support::ShippedCopy shipped;
  const char* rate = "bitrate_bit_per_s = 1_000_000\n";
  shipped.edit("piezo.toml", rate, std::string(rate) + "data_bitrate_bit_per_s = 500_000\n");
  const std::string refusal = support::refusal_of([&] { load(shipped / "piezo.toml"); });
  EXPECT_NE(refusal.find("data_bitrate_bit_per_s is 500000, expected at least bitrate_bit_per_s, 1000000"),
            std::string::npos)
      << refusal;
}

TEST(SetUp, ReadsItsObjectsAndRefusesAValueThatDoesNotFit) {
  const support::ShippedCopy shipped;
  const char* setup = "\n[[axis.amplifier_setup]]\nindex = 0x2001\nsubindex = 1\nvalue = 255\nbytes = 1\n";
  shipped.edit("piezo.toml", "sensor_node    = 2\n", std::string("sensor_node    = 2\n") + setup);
  const Config config = load(shipped / "piezo.toml");
  for (const can::AxisWire& wire :
       {controller_config(config).axes[0].wire, twin_config(config).axes[0].wire}) {
    ASSERT_EQ(wire.amplifier_setup.size(), 1u);
    EXPECT_EQ(wire.amplifier_setup[0].object, (can::SdoObject{.index = 0x2001, .subindex = 1}));
    EXPECT_EQ(wire.amplifier_setup[0].content, (can::SdoValue{.value = 255, .bytes = 1}));
    EXPECT_TRUE(wire.sensor_setup.empty());
  }
  EXPECT_NE(echo(shipped / "piezo.toml").find("[[axis.amplifier_setup]]\nindex = 8193\n"), std::string::npos);
  shipped.edit("piezo.toml", "value = 255", "value = 256");
  const std::string refusal = support::refusal_of([&] { load(shipped / "piezo.toml"); });
  EXPECT_NE(refusal.find("value is 256, expected at most 255 in 1 bytes"), std::string::npos) << refusal;
}

TEST(LabFrames, NeedAPrefixForTheStandardFrames) {
  const support::ShippedCopy shipped;
  shipped.edit("piezo.toml", "message_prefix = \"X\"", "");
  EXPECT_THROW(load(shipped / "piezo.toml"), Error);
}

TEST(LabFrames, ArePrintedAsTheyAreInForce) {
  const support::ShippedCopy shipped;
  const std::string text = echo(shipped / file);
  for (const char* line : {"[axis.frames.command]\n", "setpoint = \"Volt\"\n", "data_id = 4257\n",
                           "state_fault = [64, 65]\n", "integrity = \"none\"\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
  EXPECT_EQ(text.find("= \"\""), std::string::npos) << text;
}

struct BadPatience {
  const char* rate;
  const char* keys;
  const char* message;
};

TEST(SetUp, ReadsTimeoutAndAttemptsAndRefusesInvalidValues) {
  const std::string object =
      "\n[[axis.amplifier_setup]]\nindex = 0x2001\nsubindex = 1\nvalue = 1\nbytes = 1\n";
  const auto load_with = [&](const std::string& keys, const std::string& rate) {
    const support::ShippedCopy shipped;
    shipped.edit("galfenol.toml", "sensor_node    = 2\n", "sensor_node    = 2\n" + keys + object);
    if (!rate.empty()) shipped.edit("galfenol.toml", "rate_Hz = 1000.0", "rate_Hz = " + rate);
    if (!rate.empty()) shipped.edit("galfenol.toml", "ki_per_s           = 217.0", "ki_per_s = 1.0");
    if (!rate.empty())
      shipped.edit("galfenol.toml", "command_delay_us       = 1000.0", "command_delay_us = 2e5");
    return load(shipped / "galfenol.toml").axes[0].wire.setup_patience;
  };
  const can::SdoPatience patience = load_with("setup_timeout_ms = 2500\nsetup_attempts = 1\n", "");
  EXPECT_EQ(patience.timeout, std::chrono::milliseconds(2500));
  EXPECT_EQ(patience.attempts, 1u);
  EXPECT_EQ(load_with("", "").timeout, std::chrono::milliseconds(100)) << "as documented";
  for (const auto& bad :
       {BadPatience{"", "setup_timeout_ms = 0\n", "setup_timeout_ms is 0, expected"},
        BadPatience{"", "setup_timeout_ms = 1e6\n", "setup_timeout_ms is 1000000, expected"},
        BadPatience{"", "setup_timeout_ms = nan\n", "setup_timeout_ms is nan, expected"},
        BadPatience{"", "setup_attempts = 0\n", "setup_attempts is 0, expected"},
        BadPatience{"", "setup_attempts = 1000\n", "setup_attempts is 1000, expected"},
        BadPatience{"5.0", "setup_timeout_ms = 199\n",
                    "setup_timeout_ms is 199, expected at least one cycle, 200"}}) {
    const std::string refusal = support::refusal_of([&] { load_with(bad.keys, bad.rate); });
    EXPECT_NE(refusal.find(bad.message), std::string::npos) << refusal;
  }
}

/// lab_amplifier.toml with AmpSet of this length and a CRC of so many bits at its end; `polynomial` replaces
/// the line of the file.
Config with_longer_command(unsigned length, unsigned crc_bits, const std::string& polynomial) {
  const support::ShippedCopy shipped;
  shipped.edit("lab_amplifier.dbc", "AmpSet: 4", fmt::format("AmpSet: {}", length));
  shipped.edit("lab_amplifier.dbc", "Crc : 0|8@1+ (1,0) [0|255]",
               fmt::format("Crc : {}|{}@1+ (1,0) [0|0]", 8 * length - crc_bits, crc_bits));
  shipped.edit(file, "polynomial   = \"CRC-8H2F\"", polynomial);
  return load(shipped / file);
}

TEST(Polynomial, IsCrc16ByDefaultBeyondEightBytes) {
  const auto in_force = [](const Config& config) { return config.axes[0].wire.frames->command.polynomial; };
  EXPECT_EQ(in_force(with_longer_command(8, 8, "")), can::Crc::sae_j1850);
  EXPECT_EQ(in_force(with_longer_command(12, 16, "")), can::Crc::crc16);
  EXPECT_EQ(in_force(with_longer_command(12, 8, "polynomial = \"CRC-8H2F\"")), can::Crc::autosar_8h2f);
}

TEST(Polynomial, IsEchoedAsADefault) {
  const support::ShippedCopy shipped;
  shipped.edit("lab_amplifier.dbc", "AmpSet: 4", "AmpSet: 12");
  shipped.edit(file, "polynomial   = \"CRC-8H2F\"", "");
  EXPECT_NE(echo(shipped / file).find("polynomial = \"CRC-16\"  # default"), std::string::npos)
      << echo(shipped / file);
}

TEST(ProtectionWarnings, NameAMessageTooLongForItsCrc) {
  const auto warnings = [](unsigned length, const char* polynomial) {
    const unsigned bits = std::string_view(polynomial) == "CRC-16" ? 16 : 8;
    return protection_warnings(
        with_longer_command(length, bits, fmt::format("polynomial = \"{}\"", polynomial)));
  };
  EXPECT_EQ(
      warnings(16, "CRC-8H2F"),
      (std::vector<std::string>{
          "message AmpSet of axis x: CRC-8H2F covers 15 bytes, but detects every pair of wrong bits only in "
          "at most 14 bytes: use polynomial = \"CRC-16\", with two bytes for the CRC"}));
  EXPECT_EQ(warnings(32, "SAE-J1850").size(), 1u) << "31 bytes";
  EXPECT_TRUE(warnings(12, "CRC-8H2F").empty());
  EXPECT_TRUE(warnings(24, "SAE-J1850").empty());
  EXPECT_TRUE(warnings(64, "CRC-16").empty());
}

TEST(FormatWarnings, NameALongMessageMarkedAsClassical) {
  const support::ShippedCopy shipped;
  shipped.edit("lab_amplifier.dbc", "AmpSet: 4", "AmpSet: 12");
  shipped.edit("lab_amplifier.dbc", "Crc : 0|8@1+ (1,0) [0|255]", "Crc : 88|8@1+ (1,0) [0|255]");
  EXPECT_TRUE(format_warnings(load(shipped / file)).empty()) << "without VFrameFormat the length decides";
  shipped.edit("lab_amplifier.dbc",
               "BU_:", "BA_DEF_ BO_ \"VFrameFormat\" INT 0 15;\nBA_DEF_DEF_ \"VFrameFormat\" 0;\nBU_:");
  EXPECT_EQ(format_warnings(load(shipped / file)),
            (std::vector<std::string>{
                "message AmpSet (BO_ 2565804033) in lab_amplifier.dbc has 12 bytes, but its VFrameFormat is "
                "classical CAN: it is sent as CAN FD without bit-rate switch; set VFrameFormat = "
                "\"ExtendedCAN_FD\", and CANFD_BRS = 1 for a bit-rate switch"}));
}

// `monitor` and the controller check frames by the same rules.
TEST(Frames, HaveTheConfiguredProtection) {
  const Config config = load(HYSTCAN_SOURCE_DIR "/config/lab_amplifier.toml");
  const can::Protections found = protections(config.axes[0].wire, config.database);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_TRUE(found.at("AmpSet").crc);
  EXPECT_EQ(found.at("AmpSet").polynomial, can::Crc::autosar_8h2f);
  EXPECT_EQ(found.at("AmpSet").data_id.number, 0x10A1);
  EXPECT_TRUE(found.at("AmpGet").counter);
  EXPECT_FALSE(found.at("AmpGet").crc);
  EXPECT_FALSE(found.at("SensPos").counter);
}

}  // namespace
}  // namespace hystcan::config::frames_test
