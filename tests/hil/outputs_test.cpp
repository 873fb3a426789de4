// Standard output without a reader or on a full disk, and background jobs of a script, on real CAN.
#include <gtest/gtest.h>
#include <signal.h>

#include <string>

#include "tests/hil/live_stage.h"

namespace hystcan::outputs_test {
namespace {

using hil::Process;
using hil::QuickStage;

/// Runs `hystcan ARGUMENTS REDIRECTION`. Descriptor 4 is a pipe without a reader.
Process run(const QuickStage& stage, const std::string& arguments, const std::string& redirection) {
  const std::string pipe = stage.folder() + "/pipe";
  return Process({"sh", "-c",
                  "rm -f " + pipe + "; mkfifo " + pipe + "; exec 3<>" + pipe + " 4>" + pipe +
                      " 3>&-; exec " HYSTCAN_PROGRAM " " + arguments + " " + redirection});
}

bool says_last(const Process& program, const std::string& reason) {
  return program.err().ends_with("hystcan: standard output: cannot be written: " + reason + "\n");
}

TEST(Outputs, EndTheControllerWithAnErrorIfUnwritable) {
  QuickStage stage;
  for (const std::string redirection : {"> /dev/full", ">&-"}) {
    Process controller = run(stage, "controller " + stage.config + " --duration 0.5", redirection);
    EXPECT_EQ(controller.wait(), 1);
    EXPECT_TRUE(
        says_last(controller, redirection == ">&-" ? "Bad file descriptor" : "No space left on device"))
        << controller.err();
  }
}

TEST(Outputs, DoNotKillTheControllerWithoutAReader) {
  QuickStage stage;
  Process controller = run(stage, "controller " + stage.config, ">&4 2>&4 4>&-");
  ASSERT_TRUE(hil::eventually([&] { return stage.status().is_object(); }));
  ASSERT_TRUE(stage.reaches(0, "tracking"));
  EXPECT_EQ(stage.ctl({"stop"}).status, 0);
  EXPECT_EQ(controller.wait(), 1) << "the results are not printed";
  hil::expect_both_safe(stage.log_at_rest());
}

TEST(Outputs, EndTwinAndBusToolsWithOneOnAFullDisk) {
  QuickStage stage;
  Process tracked = run(stage, "controller " + stage.config, "");
  ASSERT_TRUE(tracked.says("x: tracking"));
  for (const std::string tool : {"monitor --interface vcan0", "monitor --interface vcan0 --once --json"}) {
    Process program = run(stage, tool, "> /dev/full");
    EXPECT_EQ(program.wait(), 1) << tool;
    EXPECT_TRUE(says_last(program, "No space left on device")) << program.err();
  }
  stage.bench.twin->send(SIGTERM);
  EXPECT_EQ(stage.bench.twin->wait(), 0);
  Process twin = run(stage, "twin " + stage.config, "> /dev/full");
  ASSERT_TRUE(twin.says("x: amplifier node")) << twin.err();
  twin.send(SIGTERM);
  EXPECT_EQ(twin.wait(), 1);
  EXPECT_TRUE(says_last(twin, "No space left on device")) << twin.err();
}

TEST(Outputs, EndMonitorWithZeroWithoutAReader) {
  const QuickStage stage;
  for (const std::string option : {"", " --json"}) {
    Process program = run(stage, "monitor --interface vcan0 --period 0.05" + option, ">&4 4>&-");
    EXPECT_EQ(program.wait(), 0);
    EXPECT_EQ(program.err(), "");
  }
}

/// A background job of a script. The shell makes it ignore SIGINT.
class Job {
 public:
  explicit Job(const std::string& arguments)
      : shell_({"sh", "-c", HYSTCAN_PROGRAM " " + arguments + " >/dev/null & echo $!; wait $!"}) {
    EXPECT_TRUE(hil::eventually([&] { return shell_.out().ends_with("\n"); }));
  }
  Process& process() { return shell_; }
  void interrupt() const { kill(std::stoi(shell_.out()), SIGINT); }
  /// Interrupts the job and returns its exit status. It sends SIGINT only once the job handles it: an earlier
  /// signal would be ignored, and a second one during the end would kill the job.
  int end() {
    EXPECT_TRUE(hil::eventually([&] { return catches_sigint() || !shell_.running(); }));
    interrupt();
    return shell_.wait();
  }

 private:
  bool catches_sigint() const {
    const std::string status =
        support::read_file("/proc/" + std::to_string(std::stoi(shell_.out())) + "/status");
    const std::size_t caught = status.find("SigCgt:");
    if (status.find("Name:\thystcan\n") == std::string::npos) return false;  // still the shell
    return caught != std::string::npos && (std::stoull(status.substr(caught + 7), nullptr, 16) & 2U) != 0;
  }

  Process shell_;
};

TEST(BackgroundJob, EndsTheControllerCleanlyOnSigint) {
  QuickStage stage;
  Job job("controller " + stage.config + " --csv " + stage.folder() + "/run.csv");
  ASSERT_TRUE(job.process().says("x: tracking"));
  job.interrupt();
  EXPECT_EQ(job.process().wait(), 0) << job.process().err();
  EXPECT_TRUE(support::read_file(stage.folder() + "/run.csv").ends_with("\n"));
  hil::expect_both_safe(stage.log_at_rest());
}

TEST(BackgroundJob, EndsABusToolOnSigint) {
  QuickStage stage;
  Process tracked = run(stage, "controller " + stage.config, "");
  ASSERT_TRUE(tracked.says("x: tracking"));
  EXPECT_EQ(Job("monitor --interface vcan0").end(), 0);
  tracked.send(SIGINT);
  EXPECT_EQ(tracked.wait(), 0) << tracked.err() << tracked.out();
  stage.bench.twin->send(SIGTERM);
  stage.bench.twin->wait();
  EXPECT_EQ(Job("twin " + stage.config).end(), 0);
}

}  // namespace
}  // namespace hystcan::outputs_test
