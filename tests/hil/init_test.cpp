// The way of docs/new_actuator.md on real SocketCAN: from an empty folder to a stage that tracks.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/hil/live_bench.h"
#include "tests/support/scratch.h"

namespace hystcan::init_test {
namespace {

using hil::json;
using hil::LiveBench;
using hil::Process;

class Init : public testing::Test {
 protected:
  std::string stage(const char* name) const { return (folder / "stage" / name).string(); }

  /// Runs `hystcan init` with the folder.
  std::string init(std::vector<std::string> words) const {
    words.insert(words.begin(), {HYSTCAN_PROGRAM, "init", (folder / "stage").string()});
    Process program(words);
    EXPECT_EQ(program.wait(), 0) << program.err();
    return program.out();
  }
  /// Records the stage on the bus.
  void excite(LiveBench& bench, std::vector<std::string> words) const {
    bench.start("excite", words);
    ASSERT_EQ(bench.controller->wait(), 0) << bench.controller->err();
  }

  const support::ScratchFolder folder;
};

TEST_F(Init, LeadsFromAnEmptyFolderToAStageThatTracks) {
  init({"--drive-min", "0", "--drive-max", "100", "--stroke", "30", "--resonance", "400", "--yes"});
  {
    LiveBench bench({"vcan0", "vcan0"}, stage("first.toml"));
    excite(bench, {"--output", stage("x.loops.csv"), "--period", "1", "--cycles", "1", "--levels", "3"});
    excite(bench, {"--output", stage("x.step.csv"), "--signal", "step", "--cycles", "3"});
  }
  std::printf("%s", init({"--continue"}).c_str());

  LiveBench bench({"vcan0", "vcan0"}, stage("stage.toml"));
  bench.start_controller({"--once", "--json"});
  ASSERT_EQ(bench.controller->wait(), 0) << bench.controller->err();
  const json run = json::parse(bench.controller->out());
  const double percent = run["axes"][0]["rms_percent"];
  std::printf("on vcan0: RMS %.4f %% of the stroke\n", percent);
  EXPECT_LT(percent, 0.3);
}

}  // namespace
}  // namespace hystcan::init_test
