// Converters accessed through IIO: the library reads a folder in place of /sys.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "node/analogue/analogue_station.h"
#include "tests/support/refusal.h"

namespace hystcan::node::iio_card_test {
namespace {

const std::filesystem::path devices = "/sys/bus/iio/devices";

void write_file(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file) << text << '\n';
}

/// Gives this process an empty /sys of its own; returns false if the system does not allow this.
bool hide_sys() {
  const std::string uid = std::to_string(getuid()), gid = std::to_string(getgid());
  if (unshare(CLONE_NEWNS) != 0) {
    if (unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
    std::ofstream("/proc/self/setgroups") << "deny";
    std::ofstream("/proc/self/uid_map") << uid << " " << uid << " 1";
    std::ofstream("/proc/self/gid_map") << gid << " " << gid << " 1";
  }
  return mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
         mount("none", "/sys", "tmpfs", MS_NOSUID, nullptr) == 0;
}

/// An output chip that does not state its limits, like ad5791, and an input chip with a buffer, like ads8688.
struct IioCardTest : testing::Test {
  void SetUp() override {
    static const bool is_hidden = hide_sys();
    if (!is_hidden) GTEST_SKIP() << "needs user namespaces";
    std::filesystem::remove_all(devices);
    write_file(devices / "iio:device0/name", "ad5791");
    write_output("raw", "0");
    write_output("scale", "0.305175781");  // 20 V / 2^16
    write_output("offset", "-32768");
    write_file(devices / "iio:device1/name", "ads8688");
    write_file(devices / "iio:device1/in_voltage-voltage_scale", "0.125");
    write_file(devices / "iio:device1/in_voltage2-voltage3_raw", "16");
    write_file(devices / "iio:device1/in_voltage_scale_available", "0.312500000 0.156250000");
    write_file(devices / "iio:device1/in_voltage_offset_available", "-32768 0");
    for (const std::string channel : {"0", "1"}) {
      write_input(channel, "raw", "36768");
      write_input(channel, "scale", "0.312500000");
      write_input(channel, "offset", "-32768");
      write_scan(channel, "type", "le:u16/16>>0");
      write_scan(channel, "index", channel);
      write_scan(channel, "en", "0");
    }
  }

  static void write_output(const std::string& name, const std::string& text) {
    write_file(devices / "iio:device0" / ("out_voltage0_" + name), text);
  }
  static void write_input(const std::string& channel, const std::string& name, const std::string& text) {
    write_file(devices / "iio:device1" / ("in_voltage" + channel + "_" + name), text);
  }
  static void write_scan(const std::string& channel, const std::string& name, const std::string& text) {
    write_file(devices / "iio:device1/scan_elements" / ("in_voltage" + channel + "_" + name), text);
  }
  static std::string content(const std::string& name) {
    std::string text;
    std::ifstream(devices / name) >> text;
    return text.c_str();  // the library also writes the NUL
  }
  static std::unique_ptr<VoltageOutput> output() {
    return open_card("iio:ad5791")->output({.channel = 0, .range = "-10..10 V"});
  }
  static std::unique_ptr<VoltageInput> input(const std::string& range = {}) {
    return open_card("iio:ads8688")->input({.channel = 0, .range = range});
  }
};

TEST_F(IioCardTest, WritesTheRawValueOfAVoltage) {
  EXPECT_TRUE(output()->write(5.0));
  EXPECT_EQ(content("iio:device0/out_voltage0_raw"), "49152");
}

TEST_F(IioCardTest, PowersAnOutputUpAfterItsFirstValue) {
  write_output("powerdown", "1");
  const auto out = output();
  EXPECT_EQ(content("iio:device0/out_voltage0_powerdown"), "1");
  EXPECT_TRUE(out->write(5.0));
  EXPECT_EQ(content("iio:device0/out_voltage0_powerdown"), "0");
}

TEST_F(IioCardTest, LimitsAnOutputByTheRawValuesThatTheDriverStates) {
  write_output("raw_available", "[16384 1 49152]");
  const auto out = open_card("iio:ad5791")->output({.channel = 0, .range = ""});
  EXPECT_NEAR(out->range().lo, -5.0, 1e-6);
  EXPECT_NEAR(out->range().hi, 5.0, 1e-6);
  EXPECT_TRUE(out->write(9.0));
  EXPECT_EQ(content("iio:device0/out_voltage0_raw"), "49152");
}

TEST_F(IioCardTest, ReadsTheVoltsOfARawValue) { EXPECT_DOUBLE_EQ(*input()->read(), 1.25); }

TEST_F(IioCardTest, DerivesTheRangeOfAnInputFromItsBits) {
  const auto in = input();
  EXPECT_DOUBLE_EQ(in->range().lo, -10.24);
  EXPECT_NEAR(in->range().hi, 10.24, 1e-3);
  EXPECT_NEAR(in->range().step, 0.3125e-3, 1e-12);
}

TEST_F(IioCardTest, SetsTheConfiguredRange) {
  const auto in = input("0..10.24 V");
  EXPECT_EQ(content("iio:device1/in_voltage0_scale"), "0.156250000");
  EXPECT_EQ(content("iio:device1/in_voltage0_offset"), "0");
  EXPECT_DOUBLE_EQ(in->range().lo, 0.0);
  EXPECT_DOUBLE_EQ(*in->read(), 5.745);
}

TEST_F(IioCardTest, ReadsADifferentialInput) {
  const auto in =
      open_card("iio:ads8688")
          ->input({.channel = 2, .range = "-1..1 V", .reference = VoltageReference::differential});
  EXPECT_DOUBLE_EQ(*in->read(), 0.002);
}

TEST_F(IioCardTest, ReportsAConversionThatFails) {
  const auto in = input();
  const auto out = output();
  EXPECT_TRUE(in->read());
  std::filesystem::remove_all(devices);
  EXPECT_FALSE(in->read()) << "an old value";
  EXPECT_FALSE(out->write(0.0));
}

TEST_F(IioCardTest, RefusesAnOutputThatAnotherOneDrives) {
  const auto first = output();
  EXPECT_EQ(support::refusal_of([] { output(); }),
            "iio:ad5791: another process already drives channel 0; stop that process (`hystcan doctor` lists "
            "running nodes)");
}

TEST_F(IioCardTest, IsCheckedWithoutAWriteBesideTheProcessThatDrivesIt) {
  write_output("raw_available", "[0 1 65535]");
  write_output("scale_available", "0.305175781 0.152587891");
  const auto driven = output();
  const auto card = open_card("iio:ad5791");
  EXPECT_NEAR(card->check_output({.channel = 0, .range = "-5..5 V"}).lo, -5.0, 1e-6);
  EXPECT_EQ(content("iio:device0/out_voltage0_scale"), "0.305175781");
  EXPECT_EQ(support::refusal_of([&] { card->check_output({.channel = 0, .range = "0..5 V"}); }),
            "iio:ad5791: channel 0 has no range \"0..5 V\"; available ranges: -10..10 V, -5..5 V");
}

TEST_F(IioCardTest, CombinesADriveAndAPositionOfTwoChips) {
  AnalogueConfig config;
  config.device = "iio:ad5791";
  config.drive_output.range = "-10..10 V";
  config.volts_per_drive = 0.1;
  config.position_input.place.device = "iio:ads8688";
  config.position_um_per_V = 3.0;
  Cards cards(open_card);
  AnalogueDevices on_chips({{.name = "x", .message_prefix = "X"}, config, {.min = 0.0, .max = 90.0}}, cards);
  on_chips.output.go_to(50.0, {}, {});
  EXPECT_EQ(content("iio:device0/out_voltage0_raw"), "49152");
  EXPECT_DOUBLE_EQ(on_chips.input.read({}).position_um, 3.75);
}

TEST_F(IioCardTest, NamesARemedyForEachMissingItem) {
  const auto refusal = [](const char* device, const auto& attempt) {
    return support::refusal_of([&] { attempt(*open_card(device)); });
  };
  const auto in = [](unsigned channel, const char* range) {
    return [=](Card& card) { card.input({.channel = channel, .range = range}); };
  };
  EXPECT_EQ(refusal("iio:ad5792", in(0, "")),
            "iio:ad5792: IIO device not found; available devices: ad5791, ads8688");
  EXPECT_EQ(refusal("iio:ads8688", in(4, "")),
            "iio:ads8688: the device has no input channel voltage4; available channels: voltage0, voltage1, "
            "voltage2-voltage3");
  EXPECT_EQ(refusal("iio:ads8688", in(0, "0..10 V")),
            "iio:ads8688: channel 0 has no range \"0..10 V\"; available ranges: -10.24..10.24 V, 0..20.48 V, "
            "-5.12..5.12 V, 0..10.24 V");
  EXPECT_EQ(
      refusal("iio:ad5791", [](Card& card) { card.output({.channel = 0, .range = ""}); }),
      "iio:ad5791: the driver does not report the range of channel 0; set range to the voltage range of the "
      "channel "
      "(example: \"0..10 V\")");
  EXPECT_EQ(
      refusal("iio:ad5791", [](Card& card) { card.line_output({.channel = 0, .range = ""}); }),
      "iio:ad5791: IIO devices have no digital lines; remove the line, or set its device to a card with "
      "digital lines");
}

}  // namespace
}  // namespace hystcan::node::iio_card_test
