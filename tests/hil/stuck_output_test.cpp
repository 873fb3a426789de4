// No program reads the log and the results of the controller: hystcan controller ... 2>&1 | sleep 1000
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>

#include "tests/hil/live_stage.h"

namespace hystcan::stuck_output_test {
namespace {

using hil::Process;
using hil::QuickStage;

/// A pipe that stays full.
class FullPipe {
 public:
  explicit FullPipe(const std::string& file) {
    EXPECT_EQ(mkfifo(file.c_str(), 0600), 0);
    pipe_ = open(file.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    const std::array<char, 4096> chunk{};
    while (write(pipe_, chunk.data(), chunk.size()) > 0) continue;
  }
  ~FullPipe() { close(pipe_); }
  FullPipe(const FullPipe&) = delete;
  FullPipe& operator=(const FullPipe&) = delete;

 private:
  int pipe_;
};

bool has_black_box(const std::string& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().filename().string().starts_with("blackbox_")) return true;
  return false;
}

TEST(StuckOutput, DoesNotHideAFaultFromStatusAndBlackBox) {
  QuickStage stage;
  const std::string file = stage.folder() + "/full";
  const FullPipe pipe(file);
  const std::string command =
      std::string("exec ") + (geteuid() == 0 ? "chrt --fifo " + std::to_string(hil::priority) + " " : "") +
      HYSTCAN_PROGRAM + " controller " + stage.config + " --interface vcan0 >" + file + " 2>&1";
  stage.bench.controller = std::make_unique<Process>(std::vector<std::string>{"sh", "-c", command});
  ASSERT_TRUE(hil::eventually([&] { return stage.status().is_object(); }));
  ASSERT_TRUE(stage.reaches(0, "tracking"));
  ASSERT_TRUE(hil::shell("cansend vcan0 000#0201")) << "another node stops node 1 by NMT";
  ASSERT_TRUE(stage.reaches(0, "faulted"));
  EXPECT_TRUE(hil::eventually([&] { return has_black_box(stage.folder()); }));
  EXPECT_EQ(stage.axis_status(1).at("state"), "tracking");
  EXPECT_EQ(stage.ctl({"stop"}).status, 0);
  EXPECT_EQ(stage.bench.controller->wait(), 1) << "of the fault";
  EXPECT_EQ(stage.log_at_rest().at("last_command").at("enable"), 0);
}

TEST(StuckOutput, DoesNotLeaveAStageDrivenByExcite) {
  QuickStage stage;
  const std::string file = stage.folder() + "/full";
  const FullPipe pipe(file);
  const auto is_driven = [&] {
    const QuickStage::Answer answer = stage.ctl_twin({"--json", "status"});
    return answer.status == 0 && hil::json::parse(answer.out).at("axes").at(0).at("amplifier") == "enabled";
  };
  const Process program({"sh", "-c",
                         "exec " HYSTCAN_PROGRAM " excite --period 1 --cycles 1 --levels 1 " + stage.config +
                             " --output " + stage.folder() + "/result >" + file + " 2>&1"});
  EXPECT_TRUE(hil::eventually(is_driven));
  EXPECT_TRUE(hil::eventually([&] { return !is_driven(); }));
  EXPECT_EQ(stage.log_at_rest().at("last_command").at("enable"), 0);
}

}  // namespace
}  // namespace hystcan::stuck_output_test
