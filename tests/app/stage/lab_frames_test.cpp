#include "app/stage/lab_frames.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "base/error.h"
#include "tests/support/refusal.h"
#include "tests/support/scratch.h"

namespace hystcan::app::lab_frames_test {
namespace {

using Signals = std::map<std::string, std::string, std::less<>>;
using Stated = std::map<std::string, std::vector<std::string>>;

/// Axes of 0 to 100 V with the frames of a DBC.
class LabFrames : public testing::Test {
 protected:
  void take_shipped(const char* name) { dbc_ = std::filesystem::path(HYSTCAN_SOURCE_DIR) / "config" / name; }
  /// A setpoint, the signals of the command, and a position.
  void take_command(const std::string& signals) {
    dbc_ = scratch_ / "lab.dbc";
    std::ofstream(dbc_) << "VERSION \"\"\n\nBU_: Host Amp Sens\n\n"
                           "BO_ 10 Set: 8 Host\n SG_ Volt : 0|16@1- (0.01,0) [0|0] \"mV\" Amp\n"
                        << signals << "\nBO_ 12 Sens: 4 Sens\n SG_ Pos : 0|32@1- (1,0) [0|0] \"nm\" Host\n";
  }

  std::vector<can::AxisWire> find(const Stated& stated, const std::vector<std::string>& names = {"x"},
                                  const char* answers = nullptr) {
    StageFacts stage;
    stage.config.bus.dbc = dbc_;
    for (const std::string& name : names) {
      AxisFacts axis;
      axis.config.wire.name = name;
      axis.config.wire.drive_unit = "V";
      stage.axes.push_back(axis);
    }
    std::istringstream in(answers == nullptr ? "" : answers);
    Questions questions(in, answers != nullptr);
    find_frames(stage, stated, questions);
    std::vector<can::AxisWire> wires;
    for (const AxisFacts& axis : stage.axes) wires.push_back(axis.config.wire);
    return wires;
  }
  std::string refusal(const Stated& stated, const std::vector<std::string>& names = {"x"}) {
    return support::refusal_of([&] { find(stated, names); });
  }

  support::ScratchFolder scratch_;
  std::filesystem::path dbc_;
};

std::string bits(const std::string& name, int at, int length = 1, const std::string& multiplexing = "") {
  return " SG_ " + name + " " + multiplexing + ": " + std::to_string(at) + "|" + std::to_string(length) +
         "@1+ (1,0) [0|0] \"\" Amp\n";
}

const Stated bare{{"command.setpoint", {"Set.Volt"}}, {"sample.position", {"Sens.Pos"}}};

Stated with(const char* key, const char* signal) {
  Stated stated = bare;
  stated[key] = {signal};
  return stated;
}

TEST_F(LabFrames, HaveTheStatedSignals) {
  take_shipped("lab_amplifier.dbc");
  const auto wires = find({{"command.setpoint", {"AmpSet.Volt"}},
                           {"command.enable", {"AmpSet.On"}},
                           {"command.counter", {"AmpSet.Cnt"}},
                           {"command.crc", {"AmpSet.Crc"}},
                           {"sample.position", {"SensPos.Pos"}},
                           {"status.output", {"AmpGet.Volt"}},
                           {"status.state", {"AmpGet.St"}},
                           {"status.states", {"0/16/32/64,65"}},
                           {"status.counter", {"AmpGet.Cnt"}}});
  ASSERT_TRUE(wires.at(0).frames && wires.at(0).frames->status);
  const can::AxisFrames& frames = *wires.at(0).frames;
  EXPECT_EQ(frames.command.message, "AmpSet");
  EXPECT_EQ(frames.command.signals, (Signals{{"setpoint", "Volt"}, {"enable", "On"}}));
  EXPECT_EQ(frames.command.integrity, can::Integrity::counter_crc);
  EXPECT_EQ(frames.command.counter, "Cnt");
  EXPECT_EQ(frames.command.crc, "Crc");
  EXPECT_EQ(frames.status->message, "AmpGet");
  EXPECT_EQ(frames.status->signals, (Signals{{"output", "Volt"}, {"state", "St"}}));
  EXPECT_EQ(frames.status->states.ready, std::vector<std::int64_t>{16});
  EXPECT_EQ(frames.status->states.fault, (std::vector<std::int64_t>{64, 65}));
  EXPECT_EQ(frames.status->integrity, can::Integrity::counter);
  EXPECT_EQ(frames.sample.message, "SensPos");
  EXPECT_EQ(frames.sample.signals, (Signals{{"position", "Pos"}}));
  EXPECT_EQ(frames.sample.integrity, can::Integrity::none);
}

TEST_F(LabFrames, HaveTheSignalsEnteredOnATerminal) {
  take_command(bits("Gate", 16) + bits("Cnt", 20, 4));
  testing::internal::CaptureStderr();
  const auto wires = find({}, {"x"}, "Set.Volt\nSens.Pos\nSet.Gate\n\n\nSet.Cnt\nSens.Pos\n");
  const std::string shown = testing::internal::GetCapturedStderr();
  EXPECT_EQ(wires.at(0).frames->command.signals, (Signals{{"setpoint", "Volt"}, {"enable", "Gate"}}));
  EXPECT_EQ(wires.at(0).frames->command.counter, "Cnt");
  EXPECT_FALSE(wires.at(0).frames->status);
  EXPECT_NE(shown.find("Commanded drive in V (axis x): Set.Volt [mV]\n  --setpoint: "), std::string::npos)
      << shown;
  EXPECT_NE(shown.find("'Sens.Pos', expected for axis x one of: Set.Gate, Set.Cnt, none"), std::string::npos)
      << shown;
}

TEST_F(LabFrames, HaveOneStatedSignalForEachAxis) {
  take_shipped("fd_stage.dbc");
  const auto wires = find({{"command.setpoint", {"Commands.SetpointX", "Commands.SetpointY"}},
                           {"command.enable", {"Commands.EnableX", "Commands.EnableY"}},
                           {"sample.position", {"Samples.PositionX", "Samples.PositionY"}},
                           {"sample.sync_counter", {"Samples.SyncCounter"}}},
                          {"x", "y"});
  EXPECT_EQ(wires.at(0).frames->command.signals.at("setpoint"), "SetpointX");
  EXPECT_EQ(wires.at(1).frames->sample.signals,
            (Signals{{"position", "PositionY"}, {"sync_counter", "SyncCounter"}}));
}

TEST_F(LabFrames, NameTheOptionAndTheSignalsForAMissingRole) {
  take_shipped("lab_amplifier.dbc");
  EXPECT_EQ(
      refusal({}),
      "--setpoint missing: Commanded drive in V (axis x), expected one of: AmpSet.Volt [mV], AmpGet.Volt [mV]");
  take_command(bits("Gate", 16) + bits("Cnt", 20, 4));
  EXPECT_EQ(
      refusal(bare),
      "--enable missing: Switch that enables the amplifier (axis x), expected one of: Set.Gate, Set.Cnt, none");
}

TEST_F(LabFrames, HaveNoEnableIfNoneIsStatedOrPossible) {
  take_command(bits("Gate", 16));
  EXPECT_FALSE(find(with("command.enable", "none")).at(0).frames->command.carries("enable"));
  take_command("");
  EXPECT_FALSE(find(bare).at(0).frames->command.carries("enable"));
}

TEST_F(LabFrames, RefuseAMultiplexedSignal) {
  take_command(bits("Page", 24, 4, "M ") + bits("On", 16, 1, "m1 "));
  EXPECT_EQ(refusal(with("command.enable", "Set.On")),
            "--enable: 'Set.On', expected for axis x one of: Set.Page, none");
}

TEST_F(LabFrames, RefuseASignalInAnotherUnit) {
  take_command("");
  EXPECT_EQ(refusal(with("sample.position", "Set.Volt")),
            "--position: 'Set.Volt', expected for axis x one of: Sens.Pos [nm]");
}

TEST_F(LabFrames, NeedTheRawValuesOfAState) {
  take_shipped("lab_amplifier.dbc");
  Stated stated{{"command.setpoint", {"AmpSet.Volt"}},
                {"command.enable", {"AmpSet.On"}},
                {"sample.position", {"SensPos.Pos"}},
                {"status.state", {"AmpGet.St"}}};
  EXPECT_NE(refusal(stated).find("--role status.states missing"), std::string::npos);
  EXPECT_NE(refusal(stated).find("in the DBC: 0 off, 16 standby, 32 on"), std::string::npos);
  for (const char* states : {"0/16/32", "0//32/64", "0/a/32/64", "0/16/32/64/65"}) {
    stated["status.states"] = {states};
    EXPECT_NE(refusal(stated).find("expected raw values as 0/16/32/64,65"), std::string::npos) << states;
  }
}

TEST_F(LabFrames, NeedACounterForACrc) {
  take_command(bits("Sum", 24, 8));
  Stated stated = with("command.crc", "Set.Sum");
  stated["command.enable"] = {"none"};
  EXPECT_EQ(refusal(stated),
            "--role command.counter missing: command.crc cannot be checked without this counter");
}

TEST_F(LabFrames, ConsistOfPrefixAndNodesForTheStandardDbc) {
  take_shipped("hystcan.dbc");
  const auto wires = find({}, {"y", "x"});
  EXPECT_EQ(wires.at(0).message_prefix, "Y");
  EXPECT_EQ(wires.at(0).amplifier_node, 3);
  EXPECT_EQ(wires.at(0).sensor_node, 4);
  EXPECT_EQ(wires.at(1).message_prefix, "X");
}

TEST_F(LabFrames, RefuseAStandardDbcWithAnotherUnitOrFewerAxes) {
  take_shipped("galfenol.dbc");
  EXPECT_NE(refusal({}).find("is A, expected V (--unit)"), std::string::npos);
  take_shipped("hystcan.dbc");
  EXPECT_NE(refusal({}, {"x", "y", "z"}).find("expected the frames of 3 axes"), std::string::npos);
}

TEST(Roles, RefuseUnknownRoles) {
  StatedRoles roles;
  add_role(roles, "status.state=AmpGet.St");
  EXPECT_EQ(roles, (StatedRoles{{"status.state", {"AmpGet.St"}}}));
  EXPECT_THROW(add_role(roles, "command.setpoint=Set.Volt"), Error) << "it has an option of its own";
  EXPECT_THROW(add_role(roles, "status.state"), Error);
}

}  // namespace
}  // namespace hystcan::app::lab_frames_test
