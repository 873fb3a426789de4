// The keys of [axis.analogue].
#include <gtest/gtest.h>

#include <ostream>

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

TEST(Analogue, OfAnAxisIsLeftOutWithoutATable) { EXPECT_FALSE(load(piezo).axes[0].analogue); }

TEST(Analogue, TakesItsDrivesFromTheControl) {
  const auto axes = analogue_axes(load(piezo, on_a_card()));
  ASSERT_EQ(axes.size(), 2u);
  EXPECT_EQ(axes[1].wire.name, "y");
  EXPECT_EQ(axes[1].drives.max, 100.0);
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
    testing::Values(Refusal{"TwoAxesOnOneOutput", of_y("drive_output.channel", "0"),
                            "output 0 of subdevice 0 is already in use by axis[0].analogue.drive_output"},
                    Refusal{"TwoAxesOnOneInput", of_y("position_input.channel", "0"),
                            "input 0 of subdevice 0 is already in use by axis[0].analogue.position_input"},
                    Refusal{"MonitorOnTheInputOfThePosition", of_y("output_input.channel", "1"),
                            "input 1 of subdevice 0 is already in use by axis[1].analogue.position_input"},
                    Refusal{"NoVoltsForADrive", of_y("volts_per_drive", "0.0"), "volts_per_drive is 0"},
                    Refusal{"NoScaleOfTheSensor", of_y("position_um_per_V", "0.0"), "position_um_per_V is 0"},
                    Refusal{"UnknownReference", of_y("drive_output.reference", "\"floating\""),
                            "reference is \"floating\""},
                    Refusal{"UnknownKey", of_y("volts_per_um", "1.0"), "unknown key"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace hystcan::config::analogue_test
