// Foreign frames at the highest rate while the axes track: only the kernel may spend time on them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <thread>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/hil/lateness.h"
#include "tests/hil/live_bench.h"
#include "tests/support/rehearsed.h"

namespace hystcan::flood_test {
namespace {

using hil::config_file;
using hil::FreshVcan;
using hil::json;
using hil::LiveBench;
using hil::Process;

/// The identifiers that the two axes of the shipped configuration use (docs/protocol/frames.md).
std::set<unsigned> own_identifiers() {
  std::set<unsigned> ids{0x000, 0x080, 0x77F};
  for (const unsigned node : {1U, 2U, 3U, 4U})
    for (const unsigned base : {0x080U, 0x180U, 0x200U, 0x580U, 0x600U, 0x700U}) ids.insert(base + node);
  return ids;
}

/// A frame of each kind for every other identifier: what `cangen -I i -L i -D i -m` sends, without our own
/// identifiers.
std::string foreign_frames() {
  const std::set<unsigned> own = own_identifiers();
  std::string log;
  for (unsigned id = 0; id < 0x800; ++id) {
    if (own.contains(id)) continue;
    const std::string payload =
        fmt::format("{:016X}", 0x0123456789ABCDEFU * (id + 1)).substr(0, 2 * (id % 9));
    for (const std::string& frame :
         {fmt::format("{:03X}#{}", id, payload), fmt::format("{:08X}#{}", id, payload),
          fmt::format("{:03X}#R", id), fmt::format("{:03X}##0{}", id, payload)})
      log += "(1000000000.000000) vcan0 " + frame + "\n";
  }
  return log;
}

json one_pass(LiveBench& bench) {
  bench.start_controller({"--once", "--json"});
  EXPECT_EQ(bench.controller->wait(), 0) << bench.controller->err();
  return json::parse(bench.controller->out());
}

std::int64_t frames_on_vcan0() {
  std::int64_t frames = 0;
  std::ifstream("/sys/class/net/vcan0/statistics/tx_packets") >> frames;
  return frames;
}

// A frame that no filter accepts takes some microseconds of the kernel's interrupt, by which a cycle may
// begin later. A frame that the controller reads takes several times as much, and 40 of them come with every
// cycle.
TEST(IcountFlood, OfForeignFramesDoesNotChangeTheControlError) {
  const config::Config config = config::load(config_file);
  const rehearsal::Outcome predicted = rehearsal::run_once(support::setup_of(config), 0.1, support::ignore);
  const FreshVcan fresh;
  LiveBench bench({"vcan0", "vcan0"});
  bench.candump.reset();
  const std::string log = (std::filesystem::path(testing::TempDir()) / "foreign.log").string();
  std::ofstream(log) << foreign_frames();
  const std::int64_t before = frames_on_vcan0();
  json flooded;
  {
    const Process flood({"canplayer", "-t", "-l", "i", "-I", log});
    flooded = one_pass(bench);
  }
  const auto cycles = static_cast<double>(flooded.at("cycles"));
  const double per_cycle = static_cast<double>(frames_on_vcan0() - before) / cycles;
  std::printf("%.1f frames a cycle, ours and foreign; %d cycles missed, %d samples missing\n", per_cycle,
              static_cast<int>(flooded.at("missed_cycles")), static_cast<int>(flooded.at("missing_samples")));
  EXPECT_GT(per_cycle, 20.0) << "more than a wire of 1 Mbit/s can carry";
  EXPECT_EQ(flooded.at("missing_samples"), 0);
  for (std::size_t i = 0; i < 2; ++i) {
    const json& axis = flooded.at("axes")[i];
    const double expected_um = predicted.axes[i].statistics.total().rms_um();
    std::printf("axis %s: RMS %.4f um in the flood, %.4f um in virtual time\n",
                predicted.axes[i].name.c_str(), static_cast<double>(axis.at("rms_um")), expected_um);
    EXPECT_EQ(axis.at("fault"), "none");
    EXPECT_GT(axis.at("rms_um"), 0.98 * expected_um) << predicted.axes[i].name;
    EXPECT_LT(hil::lateness_s(axis.at("rms_um"), expected_um, hil::shipped_speeds_um_per_s[i]),
              hil::timer_slack_s)
        << predicted.axes[i].name;
    for (const auto& [cause, frames] : axis.at("rejected_samples").items()) EXPECT_EQ(frames, 0) << cause;
  }
}

}  // namespace
}  // namespace hystcan::flood_test
