// Axes that share messages: accepted configurations, and errors with their place.
#include <gtest/gtest.h>

#include <string>

#include "config/schema/check.h"
#include "config/schema/config.h"
#include "config/schema/frames.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::sharing_test {
namespace {

constexpr const char* file = "fd_stage.toml";

struct Edit {
  const char* what;
  const char* with;
};

/// Returns the error after these edits of fd_stage.toml.
std::string error_after(std::initializer_list<Edit> edits) {
  const support::ShippedCopy shipped;
  for (const Edit& edit : edits) shipped.edit(file, edit.what, edit.with);
  return support::refusal_of<std::runtime_error>([&] { load(shipped / file); });
}

constexpr Edit other_sensor{
    "amplifier_node = 16\nsensor_node    = 8\n\n[axis.frames.sample]\nmessage      = \"Samples\"\n"
    "position     = \"PositionY\"",
    "amplifier_node = 16\nsensor_node    = 9\n\n[axis.frames.sample]\nmessage      = \"Samples\"\n"
    "position     = \"PositionY\""};

TEST(SharedFrames, AllowTwoAxesWithOneNodeAndOneMessage) {
  const Config config = load(HYSTCAN_SOURCE_DIR "/config/fd_stage.toml");
  EXPECT_EQ(first_sharing<can::SensorSample>(config, 1), 0u);
  EXPECT_EQ(first_sharing<can::AmpCommand>(config, 1), 0u);
  EXPECT_EQ(first_sharing<can::AmpCommand>(config, 0), 0u);
}

TEST(SharedFrames, MustBelongToOneNode) {
  EXPECT_NE(error_after({other_sensor})
                .find("sensor_node is 9, expected 8 as in axis x: both axes use message Samples"),
            std::string::npos)
      << error_after({other_sensor});
}

TEST(SharedFrames, AreTheOnlyWayToShareANode) {
  const support::ShippedCopy shipped;
  shipped.edit("piezo.toml", "sensor_node    = 4", "sensor_node    = 2");
  const std::string refusal = support::refusal_of<std::runtime_error>([&] { load(shipped / "piezo.toml"); });
  EXPECT_NE(refusal.find("node 2 is used by axis[0].sensor_node"), std::string::npos);
}

TEST(SharedFrames, MustHaveSeparateSignalsForEachAxis) {
  const std::string error = error_after({{"\"PositionY\"", "\"PositionX\""}});
  EXPECT_NE(error.find("signal PositionX of message Samples has bits of signal PositionX of axis x, expected "
                       "unused bits"),
            std::string::npos)
      << error;
}

TEST(SharedFrames, MustHaveOneProtection) {
  const std::string error =
      error_after({{"status       = \"StatusY\"\nintegrity    = \"counter+crc\"\ncounter      = "
                    "\"Counter\"\ncrc          = \"Crc\"\ncrc_covers   = \"identifier\"\n",
                    "status       = \"StatusY\"\nintegrity    = \"counter\"\ncounter      = "
                    "\"Counter\"\n"}});
  EXPECT_NE(error.find("integrity differs from the value of axis x, expected the same"), std::string::npos)
      << error;
}

TEST(SharedFrames, CannotVerifyAWatchdog) {
  const std::string error =
      error_after({{"repeat             = true", "repeat             = true\nverify_watchdog = true"}});
  EXPECT_NE(error.find("the commands of several axes are in the same frame"), std::string::npos) << error;
}

TEST(SharedFrames, MustBeSentWithinTheCycle) {
  const std::string error = error_after({{"_us = 245.0", "_us = 250.0"}});
  EXPECT_NE(error.find("command_deadline_us is 250, expected less than the cycle, 250"), std::string::npos)
      << error;
}

TEST(SharedFrames, MustNotBeSentBeforeTheirSamplesArrive) {
  const std::string error = error_after({{"_us = 245.0", "_us = 100.0"}});
  EXPECT_NE(
      error.find(
          "the effective command_deadline_us is 100, expected at least 243: by then all samples in message "
          "Samples have arrived"),
      std::string::npos)
      << error;
}

TEST(BackgroundSlots, MustDivideTheLargestSyncCounter) {
  const std::string error = error_after({{"= 24  ", "= 25  "}});
  EXPECT_NE(error.find("background_slots is 25, expected a divisor of 240, the highest SYNC counter"),
            std::string::npos)
      << error;
}

TEST(BackgroundSlots, MustDifferForEachNode) {
  const std::string error = error_after({{"node                = 24", "node                = 40"}});
  EXPECT_NE(
      error.find("nodes 16 (the amplifier of axis x) and 40 (the controller) have the same slot, 16 of 24, "
                 "expected node ids with different remainders after division by background_slots"),
      std::string::npos)
      << error;
}

TEST(BackgroundSlots, MustRecurTwiceInAHeartbeatPeriod) {
  const std::string error = error_after({{"heartbeat_ms = 100.0", "heartbeat_ms = 11.0"}});
  EXPECT_NE(
      error.find(
          "two rounds of 24 background slots take 12 ms, expected at most 11, the shorter heartbeat_ms"),
      std::string::npos)
      << error;
}

TEST(BackgroundSlots, MustAllowHeartbeatsWithinTheTimeout) {
  const std::string error = error_after({{"heartbeat_ms = 100.0", "heartbeat_ms = 145.0"}});
  EXPECT_NE(
      error.find("with 24 background slots two heartbeats may be 151 ms apart, expected at most 150, half of "
                 "heartbeat_timeout_ms"),
      std::string::npos)
      << error;
}

TEST(BackgroundSlots, MakeTheStatusTimeoutOfAnAxisLonger) {
  const std::string error =
      error_after({{"missing_samples    = 3\n", "missing_samples    = 3\nstatus_timeout_ms = 20.0\n"}});
  EXPECT_NE(error.find("status_timeout_ms is 20, expected at least two periods of status_every, 24, or 0"),
            std::string::npos)
      << error;
}

TEST(BackgroundSlots, AreNecessaryForTheRateOfTheShippedStage) {
  const std::string error = error_after({{"background_slots       = 24", "background_slots       = 0"}});
  EXPECT_NE(error.find("lower rate_Hz (2690 Hz fits)"), std::string::npos) << error;
}

TEST(BackgroundSlots, AreTooSlowInSuccessiveCycles) {
  const std::string error = error_after({{"node                = 24", "node                = 17"}});
  EXPECT_NE(error.find("the last command may start 298 us after its SYNC"), std::string::npos) << error;
}

TEST(CommandWarnings, NameANonzeroSignalWithoutARole) {
  Config config = load(HYSTCAN_SOURCE_DIR "/config/fd_stage.toml");
  EXPECT_TRUE(command_warnings(config).empty());
  config.axes.pop_back();
  const auto found = command_warnings(config);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], "message Commands: signal SetpointY has no role and is always sent as -200 V");
}

TEST(SharedFrames, MustHaveTheSetUpOfTheirNodeAtOneAxis) {
  const std::string error =
      error_after({{"[axis.frames.sample]\nmessage      = \"Samples\"\nposition     = \"PositionY\"",
                    "[[axis.sensor_setup]]\nindex = 0x2001\nsubindex = 0\nvalue = 1\nbytes = 1\n\n"
                    "[axis.frames.sample]\nmessage      = \"Samples\"\nposition     = \"PositionY\""}});
  EXPECT_NE(error.find("sensor_setup is for a node that axis x also uses"), std::string::npos) << error;
}

TEST(SharedFrames, MustBeSampledByOneClock) {
  const std::string error = error_after(
      {{"resolution_um      = 0.0001\n",
        "resolution_um      = 0.0001\n[axis.twin.sensor]\nsampling = \"free\"\nsample_rate_Hz = 2500.0\n"}});
  EXPECT_NE(error.find("the sample clock of the sensor differs from that of axis x"), std::string::npos)
      << error;
}

TEST(SharedFrames, MustFitIntoTheirMessage) {
  const support::ShippedCopy shipped;
  shipped.edit("fd_stage.dbc", "BO_ 392 Samples: 12", "BO_ 392 Samples: 8");
  const std::string refusal = support::refusal_of<std::runtime_error>([&] { load(shipped / file); });
  EXPECT_NE(refusal.find("signal Crc lies outside message Samples, which has 8 bytes"), std::string::npos)
      << refusal;
}

}  // namespace
}  // namespace hystcan::config::sharing_test
