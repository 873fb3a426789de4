// A laboratory's own frames between the two processes: 29-bit identifiers, nodes set up by SDO.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/hil/live_bench.h"

namespace hystcan::lab_frames_test {
namespace {

using hil::FreshVcan;
using hil::json;
using hil::LiveBench;

using Log = std::vector<std::string>;

/// The frames of the log that begin with one of the prefixes.
Log with(const Log& log, const std::vector<std::string>& prefixes) {
  Log found;
  std::ranges::copy_if(log, std::back_inserter(found), [&](const std::string& frame) {
    return std::ranges::any_of(prefixes,
                               [&](const std::string& prefix) { return frame.starts_with(prefix); });
  });
  return found;
}

std::size_t count(const Log& log, const std::string& prefix) { return with(log, {prefix}).size(); }

struct VcanLabFrames : testing::Test {
  std::string config() const { return (folder / "lab_amplifier.toml").string(); }

  /// The frames that candump received while the axis tracked its reference.
  Log frames_of_tracking() {
    LiveBench bench({"vcan0", "vcan0"}, config());
    bench.start_controller({"--duration", "1.5", "--json"});
    EXPECT_EQ(bench.controller->wait(), 0) << bench.controller->err();
    const json result = json::parse(bench.controller->out());
    const json& axis = result.at("axes")[0];
    EXPECT_EQ(axis.at("fault"), "none");
    EXPECT_LT(axis.at("rms_percent"), 1.0) << axis.dump(2);
    EXPECT_EQ(result.at("bus").at("send_refused"), 0);
    for (const auto& [cause, frames] : axis.at("rejected_samples").items()) EXPECT_EQ(frames, 0) << cause;
    return bench.frames();
  }
  support::ShippedCopy folder;
  FreshVcan fresh;
};

const char* const setup_by_sdo =
    "[[axis.amplifier_setup]]\nindex = 0x2001\nsubindex = 5\nvalue = 0x1234\nbytes = 2\n\n"
    "[[axis.sensor_setup]]\nindex = 0x2100\nsubindex = 0\nvalue = 7\nbytes = 1\n\n"
    "[axis.frames.command]";

TEST_F(VcanLabFrames, TrackOnAClassicalInterfaceOnceTheirNodesAreSetUp) {
  FreshVcan::make(16);
  folder.edit("lab_amplifier.toml", "[axis.frames.command]", setup_by_sdo);
  const Log log = frames_of_tracking();
  const auto until_started = [&](const std::vector<std::string>& prefixes, const std::string& start) {
    Log found = with(log, prefixes);
    found.erase(std::ranges::find(found, start), found.end());
    return found;
  };
  EXPECT_EQ(
      with(until_started({"601#", "581#", "000#"}, "000#0101"), {"601#", "581#"}),
      (Log{"601#2B01200534120000", "581#6001200500000000", "601#4001200500000000", "581#4B01200534120000"}));
  EXPECT_EQ(
      with(until_started({"602#", "582#", "000#"}, "000#0102"), {"602#", "582#"}),
      (Log{"602#2F00210007000000", "582#6000210000000000", "602#4000210000000000", "582#4F00210007000000"}));
  EXPECT_EQ(count(log, "601#"), 2U) << "the node is set up only once";

  EXPECT_GT(count(log, "18EF1001#"), 500U) << "AmpSet";
  EXPECT_GT(count(log, "18EE1002#"), 500U) << "SensPos";
  EXPECT_GT(count(log, "18EE1001#"), 50U) << "AmpGet, every tenth cycle";
  EXPECT_TRUE(with(log, {"201#", "181#", "182#", "00000201#"}).empty());
}

}  // namespace
}  // namespace hystcan::lab_frames_test
