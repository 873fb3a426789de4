// Names of cards, and the check that a card provides the needs of an axis.
#include "node/analogue/axis_check.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "node/analogue/analogue_station.h"
#include "node/analogue/device_name.h"
#include "tests/node/fake_card.h"
#include "tests/support/refusal.h"
#include "tests/support/scratch.h"

namespace hystcan::node::axis_check_test {
namespace {

TEST(DeviceName, NamesAFileAChipOrASimulation) {
  EXPECT_EQ(DeviceName::parsed("comedi:/dev/comedi0")->name, "/dev/comedi0");
  EXPECT_EQ(DeviceName::parsed("iio:iio:device0")->name, "iio:device0");
  EXPECT_EQ(DeviceName::parsed("simulated")->bits, 16u);
  EXPECT_EQ(DeviceName::parsed("simulated:2")->bits, 2u);
}

TEST(DeviceName, RefusesOtherTexts) {
  for (const char* text : {"", "comedi", "comedi:", "comedi:dev/comedi0", "Comedi:/dev/comedi0", "iio",
                           "iio:", "simulated:", "simulated:1", "simulated:25", "simulated:+12",
                           "simulated:12 ", "simulated:1e1", "simulated12", "simulated:-12",
                           "simulated:99999999999", "nidaq:0", "/dev/comedi0", " simulated"})
    EXPECT_FALSE(DeviceName::parsed(text)) << text;
}

struct IdentityOfACard : testing::Test {
  std::string of(const std::string& device) const { return identity_of(device_named(device), root); }
  void put(const std::filesystem::path& file, const std::string& line) const {
    std::filesystem::create_directories((root / file).parent_path());
    std::ofstream(root / file) << line << '\n';
  }
  void link(const std::filesystem::path& target, const std::filesystem::path& name) const {
    std::filesystem::create_directories((root / name).parent_path());
    std::filesystem::create_symlink(target, root / name);
  }

  const support::ScratchFolder scratch;
  const std::filesystem::path& root = scratch.path();
};

TEST_F(IdentityOfACard, IsOneForAFileAndItsLinks) {
  put("card", "");
  link("card", "link");
  const std::string folder = "comedi:" + root.string();
  EXPECT_EQ(of(folder + "/card"), of(folder + "/link"));
  EXPECT_EQ(of(folder + "/card"), of(folder + "/../" + root.filename().string() + "/card"));
  EXPECT_NE(of(folder + "/card"), of(folder + "/other"));
}

TEST_F(IdentityOfACard, IsOneForAMissingFile) {
  EXPECT_EQ(of("comedi:/dev/../dev/comedi99"), of("comedi:/dev//comedi99"));
}

TEST_F(IdentityOfACard, IsOneForACardAndItsSubdevices) {
  link("../../class/comedi/comedi0", "sys/dev/char/1:3");        // /dev/null
  link("../../class/comedi/comedi0_subd1", "sys/dev/char/1:5");  // /dev/zero
  EXPECT_EQ(of("comedi:/dev/null"), "comedi:comedi0");
  EXPECT_EQ(of("comedi:/dev/zero"), "comedi:comedi0");
}

TEST_F(IdentityOfACard, IsOneForAllNamesOfAChip) {
  put("sys/bus/iio/devices/iio:device0/name", "ads8688");
  put("sys/bus/iio/devices/iio:device1/name", "ads8688");
  put("sys/bus/iio/devices/iio:device1/label", "y-axis");
  EXPECT_EQ(of("iio:ads8688"), of("iio:iio:device0"));
  EXPECT_EQ(of("iio:y-axis"), of("iio:iio:device1"));
  EXPECT_NE(of("iio:y-axis"), of("iio:ads8688"));
  EXPECT_EQ(of("iio:absent"), "iio:absent");
}

TEST_F(IdentityOfACard, IsOneForTheUsualNumberOfBits) {
  EXPECT_EQ(of("simulated"), of("simulated:16"));
  EXPECT_NE(of("simulated"), of("simulated:12"));
}

TEST(CardsOfANode, AreOpenedOnceForAllTheirNames) {
  int opened = 0;
  Cards cards([&](const std::string&) {
    ++opened;
    return std::make_unique<FakeCard>();
  });
  EXPECT_EQ(&cards.card("comedi:/dev/x"), &cards.card("comedi:/dev/../dev/x"));
  EXPECT_EQ(opened, 1);
}

TEST(RangeText, IsTwoNumbersOfVolts) {
  EXPECT_EQ(parsed_range("-10..10 V")->lo, -10.0);
  EXPECT_EQ(parsed_range("0..10.24 V")->hi, 10.24);
  for (const char* text : {"", "0..10", "0-10 V", "10..0 V", "0..0 V", "..10 V", "0.. V", "-inf..inf V",
                           "nan..1 V", "0..10 V ", "0..1e400 V", " V"})
    EXPECT_FALSE(parsed_range(text)) << text;
}

struct AxisOnACard : testing::Test {
  std::string drives_refusal(double volts_per_drive, const DriveRange& drives,
                             const VoltageRange& range = {0.0, 10.0}) {
    config.volts_per_drive = volts_per_drive;
    return support::refusal_of([&] { check_drives(config, drives, range); });
  }
  std::string refusal_of_setpoint(double lo_um, double hi_um) {
    const PositionRange positions{{-3.0, 34.0}, {0.0, 30.0}, {lo_um, hi_um}};
    return support::refusal_of([&] { check_positions(config, positions, {0.0, 10.0, 0.1}); });
  }
  std::string warning_of_stroke(double lo_um, double hi_um) const {
    return stroke_warning(config, {{}, {lo_um, hi_um}, {}}, {0.0, 10.0, 0.1});
  }

  AnalogueConfig config = connected_to_fake();  // 3 um/V
  FakeCard card;
};

TEST_F(AxisOnACard, HasDrivesThatItsOutputReaches) {
  EXPECT_EQ(drives_refusal(0.1, {0.0, 100.0, 0.0}), "accepted");
  EXPECT_EQ(drives_refusal(0.7 / 7.0, {0.0, 100.00000000001, 0.0}), "accepted") << "rounding";
  EXPECT_EQ(drives_refusal(-0.1, {0.0, 100.0, 0.0}, {-10.0, 0.0}), "accepted");
  EXPECT_EQ(drives_refusal(0.1, {0.0, 101.0, 0.0}),
            "a drive of 101 needs 10.1 V, but the range of the output is 0 to 10 V; choose a larger range of "
            "drive_output, or limit the drive in [axis.control]");
}

TEST_F(AxisOnACard, HasNoSignOfAZeroInItsRefusals) {
  EXPECT_EQ(drives_refusal(-0.1, {0.0, 100.0, 0.0}, {1.0, 2.0}).substr(0, 23), "a drive of 0 needs 0 V,");
}

TEST_F(AxisOnACard, HasSetpointsThatItsSensorMeasures) {
  EXPECT_EQ(refusal_of_setpoint(1.0, 29.0), "accepted");
  EXPECT_EQ(
      refusal_of_setpoint(0.0, 29.0),
      "the input range 0 to 10 V measures 0.3 to 29.7 um, but the setpoints range from 0 to 29 um; correct "
      "position_um_per_V and position_zero_um, or choose another range of position_input")
      << "one bit from the end of the range is no position";
  config.position_um_per_V = -3.0;
  config.position_zero_um = 30.0;
  EXPECT_EQ(refusal_of_setpoint(1.0, 29.0), "accepted");
  EXPECT_NE(refusal_of_setpoint(1.0, 30.0), "accepted");
}

TEST_F(AxisOnACard, HasAPositionThatItsSensorMeasures) {
  config.position_zero_um = 100.0;
  EXPECT_NE(refusal_of_setpoint(110.0, 120.0)
                .find("100.3 to 129.7 um, but position_min_um and position_max_um allow -3 to 34 um"),
            std::string::npos)
      << refusal_of_setpoint(110.0, 120.0);
}

TEST_F(AxisOnACard, NamesTheRangeIfThereIsOne) {
  const auto key = [&] {
    try {
      check_positions(config, {{50.0, 60.0}, {}, {}}, {0.0, 10.0});
    } catch (const ChannelError& error) {
      return error.key;
    }
    return std::string();
  };
  EXPECT_EQ(key(), "position_um_per_V");
  config.position_input.place.range = "0..10 V";
  EXPECT_EQ(key(), "position_input.range");
}

TEST_F(AxisOnACard, IsWarnedOfAStrokeThatItsSensorDoesNotMeasure) {
  EXPECT_EQ(warning_of_stroke(1.0, 29.0), "");
  EXPECT_NE(warning_of_stroke(0.0, 29.0).find("0.3 to 29.7 um, but the stroke is 0 to 29 um"),
            std::string::npos)
      << warning_of_stroke(0.0, 29.0);
}

TEST_F(AxisOnACard, IsCheckedWithoutAnAccess) {
  const DriveRange drives{.min = 0.0, .max = 90.0, .safe = 0.0};
  EXPECT_EQ(check_channels({{}, config, drives}, card).hi, 10.0);
  config.drive_output.channel = 8;
  EXPECT_EQ(support::refusal_of([&] {
              check_channels({{}, config, drives}, card);
            }),
            "the card has 8 channels");
  EXPECT_TRUE(card.order.empty());
}

TEST_F(AxisOnACard, MayShareItsChargePump) {
  CardOutput x(config, {}, card), y(config, {}, card);
  for (int i = 0; i < 4; ++i) {
    x.works();
    EXPECT_EQ(card.lines[2], i % 2 == 0);
    y.works();
    EXPECT_EQ(card.lines[2], i % 2 == 0) << "no second edge in this cycle";
  }
}

TEST_F(AxisOnACard, HasTheKeyWithinAChannelInItsErrors) {
  const auto lacking = [] { throw ChannelError("range", Error("no such range")); };
  try {
    opened("position_input", lacking);
    FAIL();
  } catch (const ChannelError& error) {
    EXPECT_EQ(error.key, "position_input.range");
  }
}

}  // namespace
}  // namespace hystcan::node::axis_check_test
