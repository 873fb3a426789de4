// hystcan tune on real SocketCAN.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/hil/live_bench.h"
#include "tests/support/shipped.h"

namespace hystcan::tune_test {
namespace {

using hil::json;
using hil::LiveBench;
using hil::milliseconds;
using hil::Process;

// The twin is that of the rehearsal, so that both give the same values, except for the jitter of the SYNC:
// some microseconds of a delay of 106, some parts in a thousand of frequency and gain.
TEST(IcountTune, ProposesTheSameValuesOnTheBusAsInItsRehearsal) {
  const support::ShippedCopy stage;
  // 500 Hz at 1 kHz is the Nyquist frequency: by the phase of the samples, its ringing may vanish from them.
  stage.edit("piezo.toml", "resonance_Hz       = 500.0", "resonance_Hz       = 410.0");
  const std::string config = (stage / "piezo.toml").string(), output = (stage / "tuning.toml").string();
  const std::string tuned = (stage / "tuned.toml").string();
  // The emulated processor fits for seconds, the longer the more rows there are.
  const std::vector<std::string> short_steps{"--cycles", "2",    "--period", "0.2",
                                             "--output", output, "--json"};
  std::vector<std::string> words{HYSTCAN_PROGRAM, "tune", config, "--rehearse"};
  words.insert(words.end(), short_steps.begin(), short_steps.end());
  Process rehearsal(words);
  ASSERT_EQ(rehearsal.wait(), 0) << rehearsal.err();
  const json expected = json::parse(rehearsal.out());
  std::filesystem::remove(output);

  LiveBench bench({"vcan0", "vcan0"}, config);
  words = {"--write", tuned};
  words.insert(words.end(), short_steps.begin(), short_steps.end());
  bench.start("tune", words, config);
  ASSERT_EQ(bench.controller->wait(), 0) << bench.controller->err();
  const json found = json::parse(bench.controller->out());
  const auto value = [](const json& of, const char* name) { return of[name]["value"].get<double>(); };
  // Without a filter: which design is proposed may hang on the last digit of two predicted errors.
  const auto ki_per_s = [](const json& of) {
    for (const json& candidate : of["candidates"])
      if (candidate["name"] == "plain") return candidate["ki_per_s"].get<double>();
    return 0.0;
  };
  std::printf(
      "tune on vcan0: %.2f Hz, damping %.4f, delay %.4f ms, ki %.1f/s; rehearsed %.2f, %.4f, %.4f, %.1f\n",
      value(found, "natural_frequency_Hz"), value(found, "damping_ratio"), 1e3 * value(found, "delay_s"),
      ki_per_s(found), value(expected, "natural_frequency_Hz"), value(expected, "damping_ratio"),
      1e3 * value(expected, "delay_s"), ki_per_s(expected));
  EXPECT_FALSE(found["rehearsed"]);
  EXPECT_NEAR(value(found, "natural_frequency_Hz"), value(expected, "natural_frequency_Hz"), 5.0);
  EXPECT_NEAR(value(found, "damping_ratio"), value(expected, "damping_ratio"), 0.005);
  EXPECT_NEAR(value(found, "delay_s"), value(expected, "delay_s"), 0.03e-3);
  EXPECT_NEAR(ki_per_s(found) / ki_per_s(expected), 1.0, 0.1);
  EXPECT_TRUE(std::filesystem::exists(output));
  Process check({HYSTCAN_PROGRAM, "check", tuned});
  EXPECT_EQ(check.wait(), 0) << check.err();

  std::this_thread::sleep_for(milliseconds(100));
  const json log = bench.decoded();
  EXPECT_TRUE(log.at("wrong").empty()) << log.at("wrong");
  EXPECT_LE(log.at("drive_range")[1].get<double>(), 51.0 + 1e-6) << "1 % around the middle";
  EXPECT_EQ(log.at("last_command").at("enable"), 0);
  EXPECT_EQ(log.at("last_command").at("setpoint"), 0.0);
  EXPECT_EQ(log.at("seen").value("YAmpCommand", 0), 0) << "the other axis is not driven";
}

TEST(Vcan, ControlCOnTuneRampsDownAndProposesNothing) {
  const support::ShippedCopy stage;
  const std::string output = (stage / "tuning.toml").string();
  LiveBench bench({"vcan0", "vcan0"});
  bench.start("tune", {"--output", output, "--cycles", "100"}, (stage / "piezo.toml").string());
  ASSERT_TRUE(bench.controller->says("x: tracking")) << bench.controller->err();
  std::this_thread::sleep_for(milliseconds(500));
  bench.controller->send(SIGINT);
  EXPECT_EQ(bench.controller->wait(), 1);
  EXPECT_NE(bench.controller->err().find("nothing is written"), std::string::npos) << bench.controller->err();
  EXPECT_FALSE(std::filesystem::exists(output));
  std::this_thread::sleep_for(milliseconds(100));
  const json log = bench.decoded();
  EXPECT_EQ(log.at("last_command").at("enable"), 0);
  EXPECT_EQ(log.at("last_command").at("setpoint"), 0.0);
  EXPECT_NEAR(log.at("last_enabled_command").at("setpoint"), 0.0, 0.6)
      << "one cycle of 500 V/s before the end";
  EXPECT_TRUE(log.at("first_fault").is_null());
}

}  // namespace
}  // namespace hystcan::tune_test
