// `hystcan node` instead of the twin, on the card of comedi_test: output n is connected to input n.
#include <comedi.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include "node/analogue/card.h"
#include "tests/hil/live_stage.h"
#include "tests/support/refusal.h"

namespace hystcan::node_test {
namespace {

using hil::eventually;
using hil::LiveBench;
using hil::milliseconds;
using hil::Nodes;
using hil::Process;

constexpr const char* device = "comedi:/dev/comedi0";

/// The priority that the node takes: one above that of the controller.
constexpr int node_priority = hil::priority + 1;

/// The shipped stage, with axis x on channel 0 and axis y on channel 1.
struct CardFiles {
  CardFiles() {
    files.edit("piezo.toml", "[controller]\n",
               "[controller]\nrealtime.priority = " + std::to_string(hil::priority) + "\n");
    for (const std::string axis : {"0", "1"}) {
      files.edit("piezo.toml", "structure          = \"inverse+pi\"", "structure          = \"average+pi\"");
      files.edit("piezo.toml", "wipe_slew_V_per_s  = 500.0", "wipe_slew_V_per_s  = 2_000.0");
      files.edit("piezo.toml", "wipe_dwell_s       = 0.1", "wipe_dwell_s       = 0.05");
      files.edit(
          "piezo.toml", "\n[axis.twin]\n",
          "\n[axis.analogue]\ndevice = \"comedi:/dev/comedi0\"\ndrive_output = { subdevice = 1, channel = " +
              axis + " }\nvolts_per_drive = 0.09\nposition_input = { subdevice = 0, channel = " + axis +
              " }\nposition_um_per_V = 3.3\n\n[axis.twin]  # " + axis + "\n");
    }
  }
  std::string config() const { return (files / "piezo.toml").string(); }
  /// Edits the configuration of both axes.
  void edit(const std::string& what, const std::string& with) const {
    files.edit("piezo.toml", what, with);
    files.edit("piezo.toml", what, with);
  }

  support::ShippedCopy files;
};

/// The card, the node on it and the bus.
class IcountAnalogueNode : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists("/dev/comedi0"))
      GTEST_SKIP() << "needs /dev/comedi0 of comedi_test: sudo modprobe comedi_test";
    card_ = node::open_card(device);
    x_ = card_->input({.channel = 0, .range = ""});
    y_ = card_->input({.channel = 1, .range = ""});
  }

  void start_bench() {
    bench_ = std::make_unique<LiveBench>(hil::Wire{"vcan0", "vcan0"}, files_.config(), Nodes::of_the_test);
  }
  void start_node() {
    if (!bench_) start_bench();
    node_ =
        std::make_unique<Process>(hil::with_real_time_priority({HYSTCAN_PROGRAM, "node", files_.config()}));
    ASSERT_TRUE(node_->says("y: amplifier node 3, sensor node 4 on vcan0")) << node_->err();
  }
  void track() {
    ASSERT_NO_FATAL_FAILURE(start_node());
    bench_->start_controller({"--json"});
    ASSERT_TRUE(bench_->tracks()) << bench_->controller->err() << node_->err();
    ASSERT_TRUE(eventually([&] { return largest_V() > 1.0; }));
  }
  double largest_V() { return std::max(std::abs(*x_->read()), std::abs(*y_->read())); }
  /// Prints and returns the time from `cause` until both outputs are at the safe drive.
  double ms_until_safe(const char* what, const std::function<void()>& cause) {
    const auto begun = std::chrono::steady_clock::now();
    const auto now_ms = [&] {
      return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
    };
    // higher priority, so that it samples the outputs while other processes log
    set_priority(SCHED_FIFO, node_priority + 1);
    cause();
    while (largest_V() > 0.001 && now_ms() < 10'000.0)
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    const double took_ms = now_ms();
    set_priority(SCHED_OTHER, 0);
    std::printf("%s: safe after %.2f ms\n", what, took_ms);
    return took_ms;
  }
  double ms_until_safe(const char* what, pid_t process, int signal = SIGKILL) {
    return ms_until_safe(what, [&] { kill(process, signal); });
  }
  static void set_priority(int policy, int priority) {
    const sched_param param{.sched_priority = priority};
    EXPECT_EQ(sched_setscheduler(0, policy, &param), 0);
  }
  pid_t guard() const {
    const std::string log = node_->err();
    const std::string before = "guard process ";
    return std::stoi(log.substr(log.find(before) + before.size()));
  }
  /// Returns the number of frames that begin with `head`.
  long frames(const std::string& head) {
    return std::ranges::count_if(bench_->frames(),
                                 [&](const std::string& frame) { return frame.starts_with(head); });
  }

  CardFiles files_;
  std::unique_ptr<node::Card> card_;
  std::unique_ptr<node::VoltageInput> x_, y_;
  std::unique_ptr<LiveBench> bench_;
  std::unique_ptr<Process> node_;
};

/// Returns the seconds of tracking; ctest -C long requests a minute.
int tracked_s() {
  const char* asked = std::getenv("HYSTCAN_HIL_ANALOGUE_S");
  return asked == nullptr ? 1 : std::stoi(asked);
}

TEST_F(IcountAnalogueNode, SendsItsSamplesInTimeAndMissesNoCycle) {
  track();
  std::this_thread::sleep_for(std::chrono::seconds(tracked_s()));
  const hil::json report = bench_->stop_and_report(0);
  EXPECT_EQ(report.at("missed_cycles"), 0) << report.dump();
  node_->send(SIGTERM);
  EXPECT_EQ(node_->wait(), 0) << node_->err();
  EXPECT_LT(largest_V(), 0.001);

  const hil::json log = bench_->decoded_with_series();
  const auto commands = hil::series(log, "X", "AmpCommand"), samples = hil::series(log, "X", "SensorSample");
  double worst_um = 0.0;
  std::size_t last = 0;
  for (const hil::OnWire& sample : samples) {
    while (last + 1 < commands.size() && commands[last + 1].time_s < sample.time_s) ++last;
    if (commands[last].time_s > sample.time_s || commands[last].value < 1.0) continue;
    worst_um = std::max(worst_um, std::abs(sample.value - 3.3 * 0.09 * commands[last].value));
  }
  EXPECT_LT(worst_um, 0.002) << "two steps of 20 V / 65535";

  std::vector<double> after_sync_us;
  double sync_s = 0.0;
  std::istringstream lines(bench_->log());
  for (std::string line; std::getline(lines, line);) {
    const double time_s = std::strtod(line.c_str() + 1, nullptr);
    const std::string frame = line.substr(line.rfind(' ') + 1);
    if (frame.starts_with("080#")) sync_s = time_s;
    if (frame.starts_with("182#") || frame.starts_with("184#"))
      after_sync_us.push_back(1e6 * (time_s - sync_s));
  }
  std::ranges::sort(after_sync_us);
  ASSERT_GT(after_sync_us.size(), 1000u);
  const double p99_us = after_sync_us[after_sync_us.size() * 99 / 100];
  std::printf(
      "%zu samples: after their SYNC median %.1f us, p99 %.1f us, max %.1f us; at most %.4f um from "
      "the drive that was just written\n",
      after_sync_us.size(), after_sync_us[after_sync_us.size() / 2], p99_us, after_sync_us.back(), worst_um);
  EXPECT_LT(p99_us, 100.0);
}

TEST_F(IcountAnalogueNode, IsSafeWithinFiveMillisecondsOfItsOwnDeath) {
  track();
  EXPECT_LT(ms_until_safe("node killed", node_->pid()), 5.0);
}

TEST_F(IcountAnalogueNode, IsSafeWithinFiveMillisecondsOfTheDeathOfItsGuard) {
  track();
  EXPECT_LT(ms_until_safe("guard killed", guard()), 5.0);
  EXPECT_EQ(node_->wait(), 1) << node_->err();
  EXPECT_NE(node_->err().find("the guard process ended"), std::string::npos) << node_->err();
}

TEST_F(IcountAnalogueNode, IsSafeWhenItsWatchdogExpiresAfterTheDeathOfTheController) {
  track();
  EXPECT_LT(ms_until_safe("controller killed", bench_->controller->pid()), 20.0 + 5.0)
      << "command_timeout_ms is 20";
}

TEST_F(IcountAnalogueNode, IsMadeSafeByItsGuardWhileStopped) {
  track();
  EXPECT_LT(ms_until_safe("node stopped", node_->pid(), SIGSTOP), 20.0 + 5.0) << "command_timeout_ms is 20";
  node_->send(SIGCONT);
  double afterwards_V = 0.0;
  for (int i = 0; i < 500; ++i) {
    afterwards_V = std::max(afterwards_V, largest_V());
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  EXPECT_LT(afterwards_V, 0.001);
  EXPECT_TRUE(node_->says("its guard set the outputs to the safe drives")) << node_->err();
}

TEST_F(IcountAnalogueNode, EndsWithSafeOutputsWhenItsGuardIsStopped) {
  track();
  EXPECT_LT(ms_until_safe("guard stopped", guard(), SIGSTOP), 1'100.0);
  EXPECT_EQ(node_->wait(), 1) << node_->err();
}

TEST_F(IcountAnalogueNode, TracksAgainAfterAnInterfaceDownAndARestart) {
  const std::string socket = (files_.files / "ctl.sock").string();
  files_.files.edit("piezo.toml", "[controller]\n", "[controller]\ncontrol_socket = \"" + socket + "\"\n");
  start_bench();
  bench_->start_controller();  // started before the node
  ASSERT_NO_FATAL_FAILURE(start_node());
  ASSERT_TRUE(bench_->tracks()) << bench_->controller->err() << node_->err();
  const hil::Client client(socket);
  const auto both_are = [&](const std::string& state) {
    return eventually([&] {
      const hil::json axes = client.says("{\"do\": \"status\"}\n").at("axes");
      return axes[0].at("state") == state && axes[1].at("state") == state;
    });
  };
  const auto track_again = [&] {
    ASSERT_TRUE(both_are("faulted"));
    for (const char* command : {"{\"do\": \"clear\"}\n", "{\"do\": \"enable\"}\n"})
      EXPECT_EQ(client.says(command).value("error", ""), "");
    ASSERT_TRUE(both_are("tracking")) << bench_->controller->err() << node_->err();
    ASSERT_TRUE(eventually([&] { return largest_V() > 1.0; }));
  };
  ASSERT_TRUE(eventually([&] { return largest_V() > 1.0; }));
  EXPECT_LT(ms_until_safe("interface down", [] { hil::shell("ip link set vcan0 down"); }), 100.0);
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_TRUE(hil::shell("ip link set vcan0 up"));
  ASSERT_NO_FATAL_FAILURE(track_again());
  EXPECT_LT(ms_until_safe("SIGHUP", node_->pid(), SIGHUP), 5.0);
  EXPECT_EQ(node_->wait(), 0) << node_->err();
  ASSERT_NO_FATAL_FAILURE(start_node());
  ASSERT_NO_FATAL_FAILURE(track_again());
}

TEST_F(IcountAnalogueNode, ReportsARailInsteadOfAPosition) {
  files_.edit("volts_per_drive = 0.09", "volts_per_drive = 0.1");  // 100 V become 10 V, the end of the range
  ASSERT_NO_FATAL_FAILURE(start_node());
  bench_->start_controller();
  EXPECT_TRUE(bench_->controller->says("sensor status")) << bench_->controller->err();
  EXPECT_EQ(frames("082#0050"), 1) << "emergency of the sensor node of x";
}

TEST_F(IcountAnalogueNode, RefusesUnavailableChannelsInOneLine) {
  const auto refusal = [&](const std::string& what, const std::string& with) {
    files_.files.edit("piezo.toml", what, with);
    Process node({HYSTCAN_PROGRAM, "node", files_.config()});
    EXPECT_EQ(node.wait(), 2);
    files_.files.edit("piezo.toml", with, what);
    const std::string text = node.err();
    EXPECT_EQ(std::ranges::count(text, '\n'), 1) << text;
    EXPECT_NE(text.find("piezo.toml:"), std::string::npos) << text;
    return text;
  };
  const std::string output = "drive_output = { subdevice = 1, channel = 0";
  EXPECT_NE(refusal(output, "drive_output = { subdevice = 1, channel = 9")
                .find("the subdevice has 8 analogue outputs"),
            std::string::npos);
  EXPECT_NE(refusal(output, output + ", range = \"0..10 V\"")
                .find("has no range \"0..10 V\"; available ranges: -10..10 V, -5..5 V"),
            std::string::npos);
  EXPECT_NE(refusal("volts_per_drive = 0.09", "volts_per_drive = 0.2").find("a drive of 100 needs 20 V"),
            std::string::npos);
  ASSERT_NO_FATAL_FAILURE(start_node());
  EXPECT_NE(refusal("volts_per_drive = 0.09", "volts_per_drive = 0.08")
                .find("another process already drives channel 0 of subdevice 1; stop that process"),
            std::string::npos);
}

TEST_F(IcountAnalogueNode, NamesTheGroupToAUserWithoutPermission) {
  ASSERT_EQ(seteuid(65'534), 0);
  const std::string text = support::refusal_of([] { node::open_card(device); });
  ASSERT_EQ(seteuid(0), 0);
  EXPECT_NE(text.find("sudo adduser USER iocard"), std::string::npos) << text;
}

// The last test: afterwards comedi_test has no card.
TEST_F(IcountAnalogueNode, ReportsAMissingCardInsteadOfAnOldPosition) {
  track();
  const int card = open("/dev/comedi0", O_RDWR);
  ASSERT_EQ(ioctl(card, COMEDI_DEVCONFIG, nullptr), 0) << std::strerror(errno);
  close(card);
  // By the sample's status or by the emergency: whichever comes first in the cycle in which the card goes.
  EXPECT_TRUE(bench_->controller->says("x: faulted")) << bench_->controller->err();
  std::this_thread::sleep_for(milliseconds(20));
  for (const char* emergency : {"081#0050", "082#0050", "083#0050", "084#0050"})
    EXPECT_EQ(frames(emergency), 1) << emergency;
  std::vector<std::string> of_x;
  for (const std::string& frame : bench_->frames())
    if (frame.starts_with("182#")) of_x.push_back(frame);
  EXPECT_EQ(of_x.back().substr(14, 2), "02") << "status of the last sample: " << of_x.back();
}

}  // namespace
}  // namespace hystcan::node_test
