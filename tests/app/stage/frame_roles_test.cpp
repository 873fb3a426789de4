#include "app/stage/frame_roles.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace hystcan::app::frame_roles_test {
namespace {

can::Database shipped(const char* name) {
  return can::load_dbc(std::filesystem::path(HYSTCAN_SOURCE_DIR) / "config" / name);
}

can::Database lab(const std::string& messages) {
  return can::parse_dbc("VERSION \"\"\n\nBU_: Host Amp Sens\n\n" + messages, "lab.dbc");
}

/// An axis of 0 to 100 V and 30 um.
std::vector<AxisFacts> one(const char* name) {
  AxisFacts axis;
  axis.config.wire.name = name;
  axis.config.wire.drive_unit = "V";
  axis.config.control.gate.drive_max = 100.0;
  axis.travel_um = {0.0, 30.0};
  return {axis};
}

using Signals = std::map<std::string, std::string, std::less<>>;

TEST(FrameRoles, OfTheLabsAmplifierAreThoseOfItsConfiguration) {
  const AxisFacts roles = propose_roles(shipped("lab_amplifier.dbc"), one("x"), "lab_amplifier.dbc").at(0);
  ASSERT_TRUE(roles.config.wire.frames && roles.config.wire.frames->status);
  const can::AxisFrames& frames = *roles.config.wire.frames;
  EXPECT_EQ(frames.command.message, "AmpSet");
  EXPECT_EQ(frames.command.signals,
            (Signals{{"setpoint", "Volt"}, {"enable", "On"}, {"clear_fault", "Rst"}}));
  EXPECT_EQ(frames.command.integrity, can::Integrity::counter_crc);
  EXPECT_EQ(frames.command.crc, "Crc");
  EXPECT_EQ(frames.status->message, "AmpGet");
  EXPECT_EQ(frames.status->signals, (Signals{{"output", "Volt"}, {"state", "St"}}));
  EXPECT_EQ(frames.status->states.ready, std::vector<std::int64_t>{16});
  EXPECT_EQ(frames.status->states.fault, (std::vector<std::int64_t>{64, 65}));
  EXPECT_EQ(frames.status->counter, "Cnt");
  EXPECT_EQ(frames.sample.message, "SensPos");
  EXPECT_EQ(frames.sample.signals, (Signals{{"position", "Pos"}, {"status", "Err"}}));
  EXPECT_EQ(frames.sample.integrity, can::Integrity::none);
}

TEST(FrameRoles, OfTheStandardFramesAreTheirPrefixAndNodes) {
  const std::vector<AxisFacts> roles =
      propose_roles(shipped("hystcan.dbc"), {one("y")[0], one("x")[0]}, "hystcan.dbc");
  EXPECT_EQ(roles.at(0).config.wire.message_prefix, "Y");
  EXPECT_EQ(roles.at(0).config.wire.amplifier_node, 3);
  EXPECT_EQ(roles.at(0).config.wire.sensor_node, 4);
  EXPECT_EQ(roles.at(1).config.wire.message_prefix, "X");
}

TEST(FrameRoles, AreFoundWhateverTheOrderOfTheMessages) {
  const AxisFacts roles =
      propose_roles(lab("BO_ 10 Temperature: 2 Sens\n SG_ Case : 0|16@1+ (0.1,0) [0|0] \"degC\" Host\n\n"
                        "BO_ 11 PiezoReadback: 4 Amp\n SG_ Voltage : 0|16@1- (0.01,0) [0|0] \"V\" Host\n\n"
                        "BO_ 12 GapSensor: 4 Sens\n SG_ Displacement : 0|32@1- (1,0) [0|0] \"nm\" Host\n\n"
                        "BO_ 13 PiezoDemand: 4 Host\n SG_ Voltage : 0|16@1- (0.01,0) [0|0] \"V\" Amp\n"),
                    one("x"), "lab.dbc")
          .at(0);
  EXPECT_EQ(roles.config.wire.frames->command.message, "PiezoDemand");
  EXPECT_EQ(roles.config.wire.frames->status->message, "PiezoReadback");
  EXPECT_EQ(roles.config.wire.frames->sample.message, "GapSensor");
}

TEST(FrameRoles, OfSeveralAxesFollowTheirNames) {
  const auto axis = [](int id, const std::string& name) {
    return "BO_ " + std::to_string(id) + " Cmd" + name + ": 4 Host\n SG_ Set" + name +
           " : 0|16@1- (0.01,0) [0|0] \"V\" Amp\n\nBO_ " + std::to_string(id + 1) + " Pos" + name +
           ": 4 Sens\n SG_ Pos" + name + " : 0|32@1- (1,0) [0|0] \"nm\" Host\n\n";
  };
  const std::string messages = axis(10, "Y") + axis(20, "X");
  const std::vector<AxisFacts> roles = propose_roles(lab(messages), {one("x")[0], one("y")[0]}, "lab.dbc");
  EXPECT_EQ(roles.at(0).config.wire.frames->command.message, "CmdX");
  EXPECT_EQ(roles.at(0).config.wire.frames->sample.message, "PosX");
  EXPECT_EQ(roles.at(1).config.wire.frames->command.message, "CmdY");
  EXPECT_FALSE(roles.at(1).config.wire.frames->status) << "there is none";
}

TEST(FrameRoles, AreThoseWhoseRangeHoldsTheStage) {
  const AxisFacts roles =
      propose_roles(
          lab("BO_ 10 SetMonitorVoltage: 2 Host\n SG_ SetVolt : 0|16@1+ (0.001,0) [0|10] \"V\" Amp\n\n"
              "BO_ 11 HighVoltage: 2 Host\n SG_ Demand : 0|16@1+ (0.01,0) [0|150] \"V\" Amp\n\n"
              "BO_ 12 Sens: 4 Sens\n SG_ Pos : 0|32@1- (1,0) [0|0] \"nm\" Host\n"),
          one("x"), "lab.dbc")
          .at(0);
  EXPECT_EQ(roles.config.wire.frames->command.message, "HighVoltage");
}

TEST(FrameRoles, ThatAreNotThereAreNamedWithWhatIs) {
  try {
    propose_roles(lab("BO_ 10 Drive: 2 Host\n SG_ Volt : 0|16@1+ (1,0) [0|0] \"mV\" Amp\n"), one("x"),
                  "lab.dbc");
    FAIL() << "there is no position";
  } catch (const Error& error) {
    EXPECT_STREQ(
        error.what(),
        "lab.dbc: axis x has no signal like a position in um, expected one: it has no signal in that unit");
  }
}

TEST(FrameRoles, OfTheStandardFramesInAnotherUnitAreRefused) {
  EXPECT_THROW(propose_roles(shipped("galfenol.dbc"), one("x"), "galfenol.dbc"), Error);
}

TEST(FrameRoles, OfMoreAxesThanTheStandardFramesHaveAreRefused) {
  EXPECT_THROW(propose_roles(shipped("hystcan.dbc"), {one("x")[0], one("y")[0], one("z")[0]}, "hystcan.dbc"),
               Error);
}

TEST(FrameRoles, OfAStateWithoutNamedValuesAreNotGuessed) {
  const AxisFacts roles =
      propose_roles(
          lab("BO_ 10 Set: 4 Host\n SG_ Volt : 0|16@1- (0.01,0) [0|0] \"V\" Amp\n\n"
              "BO_ 11 Get: 4 Amp\n SG_ Volt : 0|16@1- (0.01,0) [0|0] \"V\" Host\n SG_ State : 16|8@1+ (1,0) "
              "[0|0] \"\" Host\n\nBO_ 12 Sens: 4 Sens\n SG_ Pos : 0|32@1- (1,0) [0|0] \"nm\" Host\n"),
          one("x"), "lab.dbc")
          .at(0);
  EXPECT_FALSE(roles.config.wire.frames->status->carries("state"));
  EXPECT_NE(table_of(roles).find("not found: status.state (the DBC does not name the values of State)"),
            std::string::npos)
      << table_of(roles);
}

// ---- the enable of the command

AxisFacts with_command(const std::string& signals) {
  return propose_roles(lab("BO_ 10 Set: 8 Host\n SG_ Volt : 0|16@1- (0.01,0) [0|0] \"V\" Amp\n" + signals +
                           "\nBO_ 12 Sens: 4 Sens\n SG_ Pos : 0|32@1- (1,0) [0|0] \"nm\" Host\n"),
                       one("x"), "lab.dbc")
      .at(0);
}

std::string bits(const std::string& name, int at, int length = 1, const std::string& multiplexing = "") {
  return " SG_ " + name + " " + multiplexing + ": " + std::to_string(at) + "|" + std::to_string(length) +
         "@1+ (1,0) [0|0] \"\" Amp\n";
}

TEST(FrameRoles, HaveTheEnableWhoseNameIsAWiderOneAndABit) {
  for (const char* name : {"AmpEna", "HvActivate", "PowerStage", "Einschalten", "OUTPUT"}) {
    const AxisFacts roles = with_command(bits(name, 16) + bits("Mode", 24, 4) + bits("Spare", 28, 4));
    ASSERT_TRUE(roles.config.wire.frames->command.carries("enable")) << name;
    EXPECT_EQ(roles.config.wire.frames->command.signals.at("enable"), name);
    EXPECT_FALSE(asks_for_enable(roles));
  }
}

TEST(FrameRoles, HaveTheEnableThatIsTheOnlyBitAmongThoseOfItsNames) {
  const AxisFacts roles = with_command(bits("ActiveRange", 24, 4) + bits("On", 16));
  EXPECT_EQ(roles.config.wire.frames->command.signals.at("enable"), "On");
}

TEST(FrameRoles, HaveNoEnableWhereItsNameSaysNothing) {
  const AxisFacts roles = with_command(bits("Gate", 16) + bits("PowerOff", 17) + bits("Rst", 18) +
                                       bits("Cnt", 20, 4) + bits("Reserved", 24, 8));
  EXPECT_FALSE(roles.config.wire.frames->command.carries("enable"));
  EXPECT_TRUE(asks_for_enable(roles));
  EXPECT_EQ(roles.enable_candidates, (std::vector<std::string>{"Gate", "PowerOff"}));
}

TEST(FrameRoles, HaveNoEnableWhereTwoBitsHaveItsName) {
  const AxisFacts roles = with_command(bits("Enable", 16) + bits("InterlockOn", 17));
  EXPECT_FALSE(roles.config.wire.frames->command.carries("enable"));
  EXPECT_TRUE(asks_for_enable(roles));
}

TEST(FrameRoles, AskForNoEnableWhereNoSignalMayBeIt) {
  const AxisFacts roles = with_command(bits("Cnt", 20, 4) + bits("Reserved", 24, 8));
  EXPECT_FALSE(asks_for_enable(roles));
  EXPECT_NE(table_of(roles).find("not found: command.enable"), std::string::npos);
}

TEST(FrameRoles, HaveTheEnableThatIsStated) {
  AxisFacts roles = with_command(bits("On", 16) + bits("Gate", 17));
  state_enable(roles, "Gate");
  EXPECT_EQ(roles.config.wire.frames->command.signals.at("enable"), "Gate");
  EXPECT_EQ(table_of(roles).find(" On "), std::string::npos) << table_of(roles);
  state_enable(roles, "none");
  EXPECT_FALSE(roles.config.wire.frames->command.carries("enable"));
}

TEST(FrameRoles, AreNoMultiplexedSignals) {
  const AxisFacts roles =
      with_command(bits("Page", 24, 4, "M ") + bits("On", 16, 1, "m1 ") + bits("Rst", 17, 1, "m1 "));
  EXPECT_FALSE(roles.config.wire.frames->command.carries("enable"));
  EXPECT_FALSE(roles.config.wire.frames->command.carries("clear_fault"));
}

}  // namespace
}  // namespace hystcan::app::frame_roles_test
