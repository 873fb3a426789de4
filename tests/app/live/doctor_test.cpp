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

TEST_F(Machine, IsDoubtfulWithAnOrdinaryKernel) {
  put("proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC Debian 6.1.0");
  EXPECT_EQ(of("kernel").verdict, Verdict::doubtful);
  EXPECT_NE(of("kernel").figure.find("PREEMPT_DYNAMIC"), std::string::npos);
  put("sys/kernel/realtime", "1");
  EXPECT_EQ(of("kernel").verdict, Verdict::good);
}

TEST_F(Machine, IsDoubtfulWithASlowClock) {
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

TEST_F(Machine, IsNotBadWithoutProcAndSys) {
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

TEST_F(Cli, DoctorGivesACureForEveryProblem) {
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
  // Root is never refused; without its capabilities, it is an ordinary user.
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

can::Frame frame_of(const config::Config& config, const char* message) {
  const can::Message& named = *config.database.find(message);
  return {.id = named.id, .extended = named.extended, .length = 8};
}

/// A kernel thread of this name.
void put_thread(const std::filesystem::path& root, int pid, const std::string& name, int priority,
                const std::string& cpus) {
  const std::filesystem::path folder = root / "proc" / std::to_string(pid);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "comm") << name << '\n';
  std::ofstream stat(folder / "stat");
  stat << pid << " (" << name << ") S";
  for (int field = 4; field < 40; ++field) stat << " 0";
  stat << ' ' << priority << ' ' << (priority > 0 ? 1 : 0) << " 0\n";
  std::ofstream(folder / "status") << "Name:\t" << name << "\nCpus_allowed_list:\t" << cpus << '\n';
}

class ReceivePath : public Machine {
 protected:
  ReceivePath() {
    std::filesystem::create_directories(root / "sys/class/net/can0/device");
    put("sys/class/net/can0/threaded", "1");
    config.realtime->priority = 45;
    put_thread(root, 210, "irq/125-can0", 50, "3");
    put_thread(root, 211, "napi/can0-8193", 80, "3");
    put_thread(root, 212, "napi/can1-8194", 0, "0-3");
  }
  Finding found() const { return app::examine_receive_path(config, "can0", root); }
};

TEST_F(ReceivePath, IsGoodWithUrgentThreadedNapiOnTheIrqProcessor) {
  EXPECT_EQ(found().verdict, Verdict::good);
  EXPECT_EQ(found().figure, "threaded NAPI, irq/125-can0 FIFO 50 on 3, napi/can0-8193 FIFO 80 on 3");
}

TEST_F(ReceivePath, NamesTheCommandsThatRepairIt) {
  put_thread(root, 210, "irq/125-can0", 40, "3");
  put_thread(root, 211, "napi/can0-8193", 0, "0-3");
  EXPECT_EQ(found().verdict, Verdict::doubtful);
  EXPECT_EQ(found().cure, "chrt -f -p 80 210; chrt -f -p 80 211; taskset -pc 3 211");
}

TEST_F(ReceivePath, RecommendsThreadedNapi) {
  put("sys/class/net/can0/threaded", "0");
  std::filesystem::remove_all(root / "proc/211");
  EXPECT_EQ(found().figure, "NAPI runs in the soft interrupt, irq/125-can0 FIFO 50 on 3");
  EXPECT_EQ(found().cure,
            "echo 1 > /sys/class/net/can0/threaded; then chrt -f -p 80 PID for each thread napi/can0-*");
}

TEST_F(ReceivePath, HasNoThreadsOnAVirtualInterface) {
  std::filesystem::remove_all(root / "sys/class/net/can0/device");
  EXPECT_EQ(found().figure, "none (virtual interface)");
}

TEST(FrameFormats, AreGoodIfNodesFollowTheDbc) {
  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  EXPECT_EQ(app::examine_formats(config, {}).figure, "no frames received");
  const std::vector heard{frame_of(config, "XSensorSample"), frame_of(config, "XAmpStatus")};
  const Finding finding = app::examine_formats(config, heard);
  EXPECT_EQ(finding.verdict, Verdict::good);
  EXPECT_EQ(finding.figure, "2 messages as defined in the DBC");
}

TEST(FrameFormats, NameAMessageInAnotherFrameFormat) {
  config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  for (can::Message& message : config.database.messages) message.fd = message.bit_rate_switch = true;
  can::Frame frame = frame_of(config, "XSensorSample");
  frame.kind = can::FrameKind::fd;
  const Finding finding = app::examine_formats(config, std::vector{frame});
  EXPECT_EQ(finding.verdict, Verdict::bad);
  EXPECT_EQ(finding.figure, "XSensorSample arrives as CAN FD without bit-rate switch");
  EXPECT_TRUE(finding.cure.find("to send CAN FD with bit-rate switch: the attributes") != std::string::npos)
      << finding.cure;
  frame.fd_flags = can::fd_bit_rate_switch;
  EXPECT_EQ(app::examine_formats(config, std::vector{frame}).verdict, Verdict::good);
  frame.kind = can::FrameKind::data;
  EXPECT_EQ(app::examine_formats(config, std::vector{frame}).figure,
            "XSensorSample arrives as a classical frame");
}

}  // namespace
}  // namespace hystcan::doctor_test
