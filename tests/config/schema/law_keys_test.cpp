// The optional keys of the control law.
#include <gtest/gtest.h>

#include <string>

#include "config/schema/config.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::law_keys_test {
namespace {

constexpr const char* before_delays = "[axis.control.delays]";

Config load_with(const std::string& inserted) {
  const support::ShippedCopy files;
  files.edit("piezo.toml", before_delays, inserted + before_delays);
  return load(files / "piezo.toml");
}

void expect_refused(const std::string& inserted, const std::string& reason) {
  const std::string refusal = support::refusal_of([&] { load_with(inserted); });
  EXPECT_NE(refusal.find(reason), std::string::npos) << refusal;
}

TEST(LawKeys, AreReadAndAbsentByDefault) {
  const Config config = load_with(
      "deadband_um = 0.01\nmeasurement_filter_Hz = 200.0\n"
      "[axis.control.notch]\nfrequency_Hz = 400.0\ndepth = 0.2\nwidth = 0.3\n");
  const controller::ControlLaw::Config& law = config.axes[0].control.law;
  EXPECT_EQ(law.deadband_um, 0.01);
  EXPECT_EQ(law.measurement_filter_Hz, 200.0);
  ASSERT_TRUE(law.notch);
  EXPECT_EQ(law.notch->frequency_Hz, 400.0);
  EXPECT_EQ(law.notch->depth, 0.2);
  EXPECT_EQ(law.notch->width, 0.3);
  EXPECT_FALSE(config.axes[1].control.law.notch);
  EXPECT_FALSE(config.axes[1].control.delays.second_order);
}

TEST(LawKeys, ANotchBeyondHalfTheRateIsRefused) {
  expect_refused("[axis.control.notch]\nfrequency_Hz = 500.0\ndepth = 0.2\nwidth = 0.3\n",
                 "frequency_Hz is 500, expected less than half of rate_Hz, 500");
}

TEST(LawKeys, ThePlantInverseIsDesignedAtLoading) {
  Config config =
      load(HYSTCAN_SOURCE_DIR "/config/piezo.toml", {{"axis[0].control.delays.plant_inverse", "true"}});
  EXPECT_TRUE(config.axes[0].control.plant_inverse);
  EXPECT_FALSE(config.axes[1].control.plant_inverse);
}

TEST(LawKeys, TwoFeedForwardsAreRefused) {
  const std::string refusal = support::refusal_of([&] {
    load(HYSTCAN_SOURCE_DIR "/config/piezo.toml",
         {{"axis[0].control.delays.plant_inverse", "true"}, {"axis[0].control.delays.second_order", "true"}});
  });
  EXPECT_NE(refusal.find("plant_inverse and second_order are both true"), std::string::npos) << refusal;
}

// No double equals 2^53 + 1 or the largest integer.
TEST(LawKeys, AnIntegerIsReadAsTheNearestNumber) {
  const auto read = [](const char* text) {
    return load(HYSTCAN_SOURCE_DIR "/config/piezo.toml", {{"axis[0].control.following_error_um", text}})
        .axes[0]
        .control.following_error.error_um;
  };
  EXPECT_EQ(read("9007199254740993"), 9007199254740992.0);
  EXPECT_EQ(read("9223372036854775807"), 9223372036854775808.0);
}

}  // namespace
}  // namespace hystcan::config::law_keys_test
