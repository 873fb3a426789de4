// Converters behind IIO on a real kernel: the driver of an ADS1015 whose registers are simulated in memory
// (i2c-stub).
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/hil/live_stage.h"

namespace hystcan::iio_test {
namespace {

namespace fs = std::filesystem;

constexpr int address = 0x48;

/// Returns the adapter of i2c-stub; empty if the module is not loaded.
fs::path stub() {
  const fs::path adapters = "/sys/bus/i2c/devices";
  if (!fs::exists(adapters)) return {};
  for (const auto& entry : fs::directory_iterator(adapters))
    if (support::read_file(entry.path() / "name").starts_with("SMBus stub")) return entry.path();
  return {};
}

class IcountAnalogueIio : public testing::Test {
 protected:
  void SetUp() override {
    adapter_ = stub();
    if (adapter_.empty() || !fs::exists("/sys/bus/i2c/drivers/ads1015") || !fs::exists("/dev/comedi0"))
      GTEST_SKIP() << "needs i2c-stub, ti-ads1015 and comedi_test: sudo modprobe -a i2c-dev ti-ads1015 "
                      "comedi_test && sudo modprobe i2c-stub chip_addr=0x48";
    const std::string name = adapter_.filename().string();
    bus_ = open(("/dev/" + name).c_str(), O_RDWR | O_CLOEXEC);
    ASSERT_GE(bus_, 0) << "i2c-dev";
    ASSERT_EQ(ioctl(bus_, I2C_SLAVE_FORCE, address), 0);
    std::ofstream(adapter_ / "new_device") << "ads1015 " << address;
    files_.edit("piezo.toml", "\n[axis.twin]\n",
                "\n[axis.analogue]\ndevice = \"iio:ads1015\"\nvolts_per_drive = 0.09\n"
                "drive_output = { device = \"comedi:/dev/comedi0\", subdevice = 1, channel = 0 }\n"
                "position_input = { channel = 0 }\nposition_um_per_V = 33\n\n"
                "[axis.twin]  # x\n");
  }
  void TearDown() override {
    if (bus_ < 0) return;
    close(bus_);
    std::ofstream(adapter_ / "delete_device") << address;
  }

  /// Sets the result of a conversion. The chip's 12 bits are the upper bits of a register, upper byte first.
  void convert_to(int raw) const {
    const auto bits = static_cast<std::uint16_t>(static_cast<unsigned>(raw) << 4U);
    i2c_smbus_data data{};
    data.word = static_cast<std::uint16_t>(bits << 8U | bits >> 8U);
    i2c_smbus_ioctl_data request{
        .read_write = I2C_SMBUS_WRITE, .command = 0, .size = I2C_SMBUS_WORD_DATA, .data = &data};
    ASSERT_EQ(ioctl(bus_, I2C_SMBUS, &request), 0);
  }

  fs::path adapter_;
  int bus_ = -1;
  support::ShippedCopy files_;
};

TEST_F(IcountAnalogueIio, ShowsThePositionOfARealDriver) {
  convert_to(1000);
  support::Process node({HYSTCAN_PROGRAM, "node", (files_ / "piezo.toml").string(), "--read"});
  const auto prints = [&](const std::string& text) {
    return support::eventually([&] { return node.out().find(text) != std::string::npos; });
  };
  EXPECT_TRUE(prints("x: position 1.00000 V = 33.0000 um")) << node.out() << node.err();
  convert_to(-500);
  EXPECT_TRUE(prints("x: position -0.50000 V = -16.5000 um")) << node.out() << node.err();
}

}  // namespace
}  // namespace hystcan::iio_test
