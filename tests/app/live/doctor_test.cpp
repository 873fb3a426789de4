// `hystcan doctor`: the checks of /proc and /sys on simulated machines, and the command as a process.
#include "app/live/doctor.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/app/command_line/cli.h"
#include "tests/support/scratch.h"

namespace hystcan::doctor_test {
namespace {

using app::Finding;
using app::Verdict;

/// A tree of files like /proc and /sys of a well-configured machine; tests change it.
class Machine : public testing::Test {
 protected:
  Machine() {
    put("proc/sys/kernel/osrelease", "6.1.0-rt");
    put("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian");
    put("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc");
    put("sys/devices/system/cpu/online", "0-3");
    put("sys/devices/system/cpu/isolated", "2-3");
    for (const char* cpu : {"0", "1", "2", "3"}) {
      put(std::string("sys/devices/system/cpu/cpu") + cpu + "/cpufreq/scaling_governor", "performance");
      put(std::string("sys/devices/system/cpu/cpu") + cpu + "/cpuidle/state1/latency", "2");
    }
    config.rate_Hz = 1000.0;
    config.realtime.emplace().cpus = {2, 3};
  }

  void put(const std::filesystem::path& file, const std::string& text) const {
    std::filesystem::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text << '\n';
  }
  Finding of(const std::string& check) const {
    const auto findings = app::examine_machine(config, root);
    const auto found = std::ranges::find(findings, check, &Finding::check);
    if (found != findings.end()) return *found;
    ADD_FAILURE() << "no check " << check;
    return {};
  }

  const support::ScratchFolder scratch;
  const std::filesystem::path& root = scratch.path();
  controller::CommonConfig config;
};

TEST_F(Machine, IsGoodInEveryCheckIfItIsWellConfigured) {
  for (const Finding& finding : app::examine_machine(config, root)) {
    EXPECT_EQ(finding.verdict, Verdict::good) << finding.check << ": " << finding.figure;
    EXPECT_EQ(finding.cure, "") << finding.check;
  }
}

TEST_F(Machine, WithAnOrdinaryKernelIsDoubtful) {
  put("proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC Debian 6.1.0");
  EXPECT_EQ(of("kernel").verdict, Verdict::doubtful);
  EXPECT_NE(of("kernel").figure.find("PREEMPT_DYNAMIC"), std::string::npos);
  put("sys/kernel/realtime", "1");
  EXPECT_EQ(of("kernel").verdict, Verdict::good);
}

TEST_F(Machine, WithASlowClockIsDoubtful) {
  put("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  EXPECT_EQ(of("clock source").verdict, Verdict::doubtful);
}

TEST_F(Machine, IsJudgedByTheProcessorsInUse) {
  put("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave");
  put("sys/devices/system/cpu/cpu0/cpuidle/state3/latency", "900");
  EXPECT_EQ(of("CPU governor").verdict, Verdict::good);
  EXPECT_EQ(of("C-states").verdict, Verdict::good);
  config.realtime->cpus.clear();
  EXPECT_EQ(of("CPU governor").verdict, Verdict::doubtful);
  EXPECT_EQ(of("C-states").verdict, Verdict::doubtful);
  put("sys/devices/system/cpu/cpu0/cpuidle/state3/disable", "1");
  EXPECT_EQ(of("C-states").verdict, Verdict::good) << "a state that is never entered";
}

TEST_F(Machine, MustHaveTheConfiguredProcessors) {
  config.realtime->cpus = {3, 4};
  EXPECT_EQ(of("processors").verdict, Verdict::bad);
  config.realtime->cpus = {1};
  EXPECT_EQ(of("processors").verdict, Verdict::doubtful) << "not isolated";
}

TEST_F(Machine, WithoutAnyFilesInProcAndSysIsAccepted) {
  std::filesystem::remove_all(root);
  config.realtime->cpus.clear();
  for (const Finding& finding : app::examine_machine(config, root))
    EXPECT_NE(finding.verdict, Verdict::bad) << finding.check << ": " << finding.figure;
}

TEST(CpuList, IsParsedInTheFormOfTheKernel) {
  EXPECT_EQ(app::parse_cpu_list("0"), (std::set<std::int64_t>{0}));
  EXPECT_EQ(app::parse_cpu_list("0-2,5,7-8"), (std::set<std::int64_t>{0, 1, 2, 5, 7, 8}));
  for (const char* none : {"", "x", "1-", "-3", "1,,2", "0-99999999999"})
    EXPECT_TRUE(app::parse_cpu_list(none).empty()) << none;
}

TEST_F(Cli, DoctorGivesACureForEveryVerdictThatIsNotGoodAndAMatchingExitStatus) {
  Process program({HYSTCAN_PROGRAM, "doctor", path("piezo.toml"), "--interface", "nocan7", "--json"});
  EXPECT_EQ(program.wait(), failed) << "there is no such interface";
  const nlohmann::json answer = nlohmann::json::parse(program.out());
  EXPECT_EQ(answer.at("verdict"), "bad");
  std::set<std::string> checks;
  for (const auto& check : answer.at("checks")) {
    checks.insert(check.at("check"));
    EXPECT_EQ(check.at("verdict") == "good", check.at("cure") == "") << check;
    EXPECT_NE(check.at("figure"), "") << check;
  }
  for (const char* name : {"kernel", "clock source", "CPU governor", "C-states", "processors", "build",
                           "priority", "locked memory", "limits", "wake-up", "interface"})
    EXPECT_TRUE(checks.contains(name)) << name;
}

TEST_F(Cli, DoctorReportsARefusedPriorityAndItsCure) {
  shipped.edit("piezo.toml", "rate_Hz = 1000.0",
               "rate_Hz = 1000.0\nrealtime.priority = 60\nrealtime.cpus = [1023]");
  // Nothing is refused to root; without its capabilities it is a user as any other.
  std::vector<std::string> command{HYSTCAN_PROGRAM, "doctor", path("piezo.toml")};
  if (geteuid() == 0) command.insert(command.begin(), {"setpriv", "--bounding-set=-all"});
  Process program(command);
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.out().find("cpus [1023]"), std::string::npos) << program.out();
  if (program.out().find("SCHED_FIFO 60 given") != std::string::npos) GTEST_SKIP() << "granted to this user";
  EXPECT_NE(program.out().find("LimitRTPRIO=60"), std::string::npos) << program.out();
}

TEST_F(Cli, CheckAcceptsABlackBoxFolderAndRefusesAProcessorOutOfRange) {
  shipped.edit("piezo.toml", "rate_Hz = 1000.0",
               "rate_Hz = 1000.0\nblack_box_dir = \"boxes\"\nrealtime.cpus = [0, 1024]");
  Process program({HYSTCAN_PROGRAM, "check", path("piezo.toml")});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("processor 1024, expected 0 to 1023"), std::string::npos) << program.err();
}

}  // namespace
}  // namespace hystcan::doctor_test
