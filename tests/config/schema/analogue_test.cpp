// The keys of [axis.analogue].
#include <gtest/gtest.h>

#include <ostream>

#include "config/schema/check.h"
#include "config/schema/config.h"
#include "tests/support/refusal.h"

namespace hystcan::config::analogue_test {
namespace {

constexpr const char* piezo = HYSTCAN_SOURCE_DIR "/config/piezo.toml";

/// Both axes on one card, with `changes`.
std::vector<Setting> on_a_card(const std::vector<Setting>& changes = {}) {
  std::vector<Setting> settings;
  for (const std::string axis : {"0", "1"}) {
    const auto set = [&](const std::string& key, const std::string& value) {
      settings.push_back({"axis[" + axis + "].analogue." + key, value});
    };
    set("device", "\"comedi:/dev/comedi0\"");
    set("volts_per_drive", "0.1");
    set("position_um_per_V", "3.0");
    set("drive_output.channel", axis);
    set("position_input.channel", axis);
  }
  settings.insert(settings.end(), changes.begin(), changes.end());
  return settings;
}

Setting of_y(const std::string& key, const std::string& value) { return {"axis[1].analogue." + key, value}; }

TEST(Analogue, IsReadWithItsChannelsAndLines) {
  const Config config =
      load(piezo,
           on_a_card({of_y("drive_output.subdevice", "1"), of_y("drive_output.range", "\"0..10 V\""),
                      of_y("position_input.average", "4"),
                      of_y("position_input.reference", "\"differential\""), of_y("interlock_line.line", "2"),
                      of_y("interlock_line.active", "\"low\""), of_y("command_timeout_ms", "5.0")}));
  const node::AnalogueConfig& analogue = *config.axes[1].analogue;
  EXPECT_EQ(analogue.drive_output.subdevice, 1u);
  EXPECT_EQ(analogue.drive_output.range, "0..10 V");
  EXPECT_EQ(analogue.position_input.average, 4u);
  EXPECT_EQ(analogue.position_input.place.reference, node::VoltageReference::differential);
  EXPECT_EQ(analogue.interlock_line->place.channel, 2u);
  EXPECT_EQ(analogue.interlock_line->active, node::ActiveLevel::low);
  EXPECT_EQ(analogue.amplifier.command_timeout, std::chrono::milliseconds(5));
  EXPECT_FALSE(analogue.enable_line);
}

TEST(Analogue, MayHaveTheSameChannelOfTwoCards) {
  const Config config = load(piezo, on_a_card({of_y("position_input.device", "\"iio:ads8688\""),
                                               of_y("position_input.channel", "0")}));
  EXPECT_EQ(config.axes[1].analogue->position_input.place.device, "iio:ads8688");
}

TEST(Analogue, IsAbsentWithoutATable) { EXPECT_FALSE(load(piezo).axes[0].analogue); }

TEST(Analogue, UsesTheDriveRangeOfTheControl) {
  const auto axes = analogue_axes(load(piezo, on_a_card()));
  ASSERT_EQ(axes.size(), 2u);
  EXPECT_EQ(axes[1].wire.name, "y");
  EXPECT_EQ(axes[1].drives.max, 100.0);
}

std::string refusal_with(const std::vector<Setting>& changes) {
  return support::refusal_of([&] { load(piezo, on_a_card(changes)); });
}

/// Sets this key of both axes.
std::vector<Setting> of_both(const std::string& key, const std::string& value) {
  return {{"axis[0].analogue." + key, value}, of_y(key, value)};
}

TEST(Analogue, SharesInterlocksAndChargePumpsAlone) {
  EXPECT_EQ(refusal_with(of_both("interlock_line.line", "2")), "accepted");
  EXPECT_EQ(refusal_with(of_both("charge_pump_line.line", "2")), "accepted");
  const std::string refusal = refusal_with(of_both("enable_line.line", "2"));
  EXPECT_NE(refusal.find("line 2 of subdevice 0 is already in use by axis[0].analogue.enable_line, expected"),
            std::string::npos)
      << refusal;
  EXPECT_NE(refusal_with({{"axis[0].analogue.interlock_line.line", "2"}, of_y("charge_pump_line.line", "2")}),
            "accepted");
}

TEST(Analogue, HasOneLevelOfASharedLine) {
  std::vector<Setting> changes = of_both("interlock_line.line", "2");
  changes.push_back(of_y("interlock_line.active", "\"low\""));
  EXPECT_EQ(refusal_with(changes),
            "axis[1].analogue.interlock_line.active: active is \"low\", expected \"high\" as in "
            "axis[0].analogue.interlock_line, which uses the same line");
}

TEST(Analogue, NeedsAWatchdogThatTripsWithinItsVerification) {
  const std::vector<Setting> verified{{"axis[1].control.verify_watchdog", "true"},
                                      of_y("command_timeout_ms", "1000.0")};
  EXPECT_NE(refusal_with(verified).find(
                "expected less than 1000, the time for which verify_watchdog waits for a trip"),
            std::string::npos)
      << refusal_with(verified);
}

TEST(Analogue, WarnsOfAStrokeBeyondTheRangeOfItsSensor) {
  const auto warnings = stroke_warnings(load(piezo, on_a_card({of_y("position_input.range", "\"0..9 V\"")})));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with(
      "axis y: the input range 0 to 9 V measures 0 to 27 um, but the stroke is 1.5 to "))
      << warnings[0];
  EXPECT_TRUE(stroke_warnings(load(piezo, on_a_card())).empty()) << "only the card knows its range";
}

struct Refusal {
  const char* name;
  Setting change;
  const char* message;
  friend void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }
};

class AnalogueRefusal : public testing::TestWithParam<Refusal> {};

TEST_P(AnalogueRefusal, NamesTheKey) {
  const std::string refusal = support::refusal_of([] { load(piezo, on_a_card({GetParam().change})); });
  EXPECT_NE(refusal.find(GetParam().message), std::string::npos) << refusal;
}

INSTANTIATE_TEST_SUITE_P(
    Config, AnalogueRefusal,
    testing::Values(
        Refusal{"TwoAxesOnOneOutput", of_y("drive_output.channel", "0"),
                "output 0 of subdevice 0 is already in use by axis[0].analogue.drive_output"},
        Refusal{"TwoAxesOnOneInput", of_y("position_input.channel", "0"),
                "input 0 of subdevice 0 is already in use by axis[0].analogue.position_input"},
        Refusal{"MonitorOnTheInputOfThePosition", of_y("output_input.channel", "1"),
                "input 1 of subdevice 0 is already in use by axis[1].analogue.position_input"},
        Refusal{"NoVoltsForADrive", of_y("volts_per_drive", "0.0"),
                "volts_per_drive is 0, expected a number whose magnitude is >= 1e-06"},
        Refusal{"NoScaleOfTheSensor", of_y("position_um_per_V", "0.0"), "position_um_per_V is 0"},
        Refusal{"TinyScale", of_y("volts_per_drive", "-1e-300"), "volts_per_drive is -1e-300"},
        Refusal{"HugeScale", of_y("position_um_per_V", "1e300"), "position_um_per_V is 1e+300"},
        Refusal{"NoNumberAsAScale", of_y("volts_per_drive", "nan"), "volts_per_drive is nan"},
        Refusal{"HugeOffset", of_y("position_zero_um", "-1e300"), "position_zero_um is -1e+300"},
        Refusal{"HugeChannel", of_y("drive_output.channel", "65536"), "channel is 65536"},
        Refusal{"HugeSubdevice", of_y("drive_output.subdevice", "256"), "subdevice is 256"},
        Refusal{"LongWatchdog", of_y("command_timeout_ms", "10001"), "command_timeout_ms is 10001"},
        Refusal{"UnknownDevice", of_y("device", "\"nidaq:0\""),
                "axis[1].analogue.device: device is \"nidaq:0\", expected comedi:/dev/comedi0"},
        Refusal{"UnknownDeviceOfALine", of_y("enable_line", "{ line = 0, device = \"iio:\" }"),
                "device is \"iio:\", expected"},
        Refusal{"LineOfAChip", of_y("enable_line", "{ line = 0, device = \"iio:ad5791\" }"),
                "IIO devices have no digital lines, expected a device with digital lines"},
        Refusal{"SimulatedChannelOfARealAxis", of_y("position_input.device", "\"simulated\""),
                "expected the device of the axis, or a real card"},
        Refusal{"OtherNameOfACard",
                of_y("drive_output", "{ device = \"comedi:/dev//comedi0\", channel = 0 }"),
                "is already in use by axis[0].analogue.drive_output"},
        Refusal{"RangeOfAnotherForm", of_y("drive_output.range", "\"0-10V\""),
                "drive_output.range: range is \"0-10V\", expected a range like 0..10 V"},
        Refusal{"RangeWithoutTheDrives", of_y("drive_output.range", "\"0..5 V\""),
                "volts_per_drive: a drive of 100 needs 10 V, but the range of the output is 0 to 5 V"},
        Refusal{"RangeWithoutTheSetpoints", of_y("position_input.range", "\"0..5 V\""),
                "position_input.range: the input range 0 to 5 V measures 0 to 15 um, but the setpoints range "
                "from "
                "5 to 25 um"},
        Refusal{"RareStatus", of_y("status_every", "501"),
                "status_every is 501: two periods take 1002 ms, expected at most 1000"},
        Refusal{"WatchdogWithinTwoCycles", of_y("command_timeout_ms", "1.9"),
                "command_timeout_ms is 1.9, expected at least two cycles, 2"},
        Refusal{"RelayThatIsTooSlow", of_y("enable_delay_ms", "499"),
                "enable_delay_ms is 499, expected at most 498, the time for which the controller waits"},
        Refusal{"UnknownReference", of_y("drive_output.reference", "\"floating\""),
                "reference is \"floating\""},
        Refusal{"UnknownKey", of_y("volts_per_um", "1.0"), "unknown key"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace hystcan::config::analogue_test
