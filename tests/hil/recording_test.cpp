// Records a run while the stage tracks on vcan: the remains after a kill, and the effect of a full disk on
// control.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <thread>

#include "tests/hil/live_stage.h"

namespace hystcan::recording_test {
namespace {

using hil::json;
using hil::milliseconds;
using hil::QuickStage;
using support::Process;

std::string output_of(const std::vector<std::string>& words) {
  std::vector<std::string> command{HYSTCAN_PROGRAM};
  command.insert(command.end(), words.begin(), words.end());
  Process process(command);
  EXPECT_EQ(process.wait(), 0) << process.err();
  return process.out();
}

json recording_of(const QuickStage& stage) { return stage.status().at("recording"); }

TEST(RecordedRun, IsListedAndExportedAfterAKill) {
  QuickStage stage;
  const std::string runs = stage.folder() + "/runs";
  stage.files.edit("piezo.toml", "[twin]\n", "[record]\nbus_log = true\n\n[twin]\n");
  stage.start({"--record", runs});
  std::this_thread::sleep_for(milliseconds(1500));
  stage.bench.controller->send(SIGKILL);
  stage.bench.controller->wait();
  const json listed = json::parse(output_of({"runs", runs, "--json"}));
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].at("state"), "not closed (killed)");
  EXPECT_GT(listed[0].at("last_s").get<double>(), 1.0);
  EXPECT_GT(listed[0].at("axes")[0].at("tracked_rows"), 300);
  const std::string run = listed[0].at("run");
  const std::string csv = output_of({"export", run, "--axis", "x", "--signals", "position_um,state"});
  EXPECT_TRUE(csv.ends_with(",tracking\n"))
      << csv.substr(csv.size() - std::min<std::size_t>(csv.size(), 200));
  const std::string bus_log = support::read_file(run + "/bus_0001.log");
  EXPECT_NE(bus_log.find(" vcan0 080#"), std::string::npos) << "SYNCs";
  EXPECT_TRUE(bus_log.ends_with("\n"));
}

TEST(RecordedRun, EndsOnAFullDiskAndControlDoesNot) {
  QuickStage stage;
  const std::string runs = stage.folder() + "/runs";
  std::filesystem::create_directory(runs);
  if (::mount("tmpfs", runs.c_str(), "tmpfs", 0, "size=256k") != 0)
    GTEST_SKIP() << "a small tmpfs needs root: " << std::strerror(errno);
  stage.start({"--record", runs});
  EXPECT_TRUE(hil::eventually([&] { return recording_of(stage).contains("failure"); }));
  const json recording = recording_of(stage);
  EXPECT_EQ(recording.at("on"), false);
  EXPECT_NE(recording.at("failure").get<std::string>().find("No space left on device"), std::string::npos);
  std::this_thread::sleep_for(milliseconds(1000));
  for (const std::size_t axis : {0U, 1U}) {
    const json status = stage.axis_status(axis);
    EXPECT_EQ(status.at("state"), "tracking");
    EXPECT_EQ(status.at("fault"), "none");
  }
  EXPECT_GT(recording_of(stage).at("rows_lost"), 0);
  EXPECT_TRUE(stage.bench.controller->says("control continues"));
  EXPECT_EQ(stage.ctl({"stop"}).status, 0);
  EXPECT_EQ(stage.bench.controller->wait(), 0) << stage.bench.controller->err();
  EXPECT_TRUE(output_of({"runs", runs}).find("RMS um") != std::string::npos);
  ::umount2(runs.c_str(), MNT_DETACH);
}

}  // namespace
}  // namespace hystcan::recording_test
