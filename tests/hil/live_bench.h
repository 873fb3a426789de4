// A twin and a controller as processes on real SocketCAN, and a log of the frames on the bus.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/hil/bus_log.h"
#include "tests/support/process.h"

namespace hystcan::hil {

using nlohmann::json;
using std::chrono::milliseconds;
using support::eventually;
using support::Process;

inline const std::string config_file = HYSTCAN_SOURCE_DIR "/config/piezo.toml";

struct Wire {
  const char* controller_side;
  const char* twin_side;
};
inline void PrintTo(const Wire& wire, std::ostream* out) { *out << wire.controller_side; }

/// Priority of the controller and of its nodes: they share the one processor of the guest, and each answers
/// all frames of a cycle before the other runs. With different priorities each frame would switch processes,
/// which is expensive for an emulated processor: 2.9 s of host time instead of 1.8 s for one second of two
/// axes at 1 kHz.
constexpr int priority = 50;
/// Priority of a controller whose times are measured: no node delays its SYNC or its answer to a sample, as
/// if the nodes ran on another processor.
constexpr int priority_over_nodes = 60;

/// Adds real-time scheduling (FIFO) to the command if the user is allowed to use it, as for a real actuator.
inline std::vector<std::string> with_real_time_priority(std::vector<std::string> command,
                                                        int fifo_priority = priority) {
  if (geteuid() == 0) command.insert(command.begin(), {"chrt", "--fifo", std::to_string(fifo_priority)});
  return command;
}

inline bool shell(const std::string& command) { return std::system(command.c_str()) == 0; }

/// Counts the programs that receive every frame of an interface, such as candump, record and monitor.
/// Construct it before starting another one.
class Listeners {
 public:
  explicit Listeners(std::string interface) : interface_(std::move(interface)), before_(count()) {}
  [[nodiscard]] bool are_more_by(std::size_t more) const {
    return eventually([&] { return count() >= before_ + more; });
  }

 private:
  std::size_t count() const {
    std::ifstream list("/proc/net/can/rcvlist_all");
    std::size_t listeners = 0;
    for (std::string line, device; std::getline(list, line);)
      if (std::istringstream(line) >> device && device == interface_) ++listeners;
    return listeners;
  }

  std::string interface_;
  std::size_t before_;
};

/// Creates vcan0 before the test and again after it, whatever the test does to it.
struct FreshVcan {
  FreshVcan() { make(); }
  ~FreshVcan() { make(); }
  FreshVcan(const FreshVcan&) = delete;
  FreshVcan& operator=(const FreshVcan&) = delete;
  static void make(int mtu = 72) {
    shell("ip link del vcan0 2>/dev/null");
    EXPECT_TRUE(shell("ip link add dev vcan0 type vcan && ip link set vcan0 mtu " + std::to_string(mtu) +
                      " && ip link set vcan0 up"));
  }
};

/// Returns true if a socket may exceed the kernel's limit of buffers: only for root of the machine, not of a
/// namespace.
inline bool may_force_buffers() {
  const int probe = socket(AF_UNIX, SOCK_DGRAM, 0);
  const int size = 1 << 20;
  const bool may = setsockopt(probe, SOL_SOCKET, SO_RCVBUFFORCE, &size, sizeof size) == 0;
  close(probe);
  return may;
}

/// The nodes that answer the controller.
enum class Nodes : std::uint8_t { twin, of_the_test };

/// Starts candump, and the twin unless the test has its own nodes; a test starts the controller.
class LiveBench {
 public:
  explicit LiveBench(Wire wire, std::string config = config_file, Nodes nodes = Nodes::twin)
      : wire_(wire), config_(std::move(config)) {
    log_file_ = (std::filesystem::path(testing::TempDir()) / "hil.log").string();
    // -L prints the log format with the kernel's timestamps; the shell only opens the file. Root gets a
    // buffer for all frames of a test, which candump reads at the end, because switching processes is
    // expensive for an emulator. Another user gets the maximum that the kernel allows.
    const Listeners listeners(wire.controller_side);
    candump = std::make_unique<Process>(std::vector<std::string>{
        "sh", "-c", std::string("exec candump -L -r 400000000 ") + wire.controller_side + " >" + log_file_});
    EXPECT_TRUE(listeners.are_more_by(1)) << candump->err();
    if (may_force_buffers()) candump->send(SIGSTOP);
    if (nodes == Nodes::twin) start_twin();
  }

  void start_twin(const std::vector<std::string>& options = {}) {
    std::vector<std::string> command{HYSTCAN_PROGRAM, "twin",          config_,
                                     "--interface",   wire_.twin_side, "--force-interface"};
    command.insert(command.end(), options.begin(), options.end());
    twin = std::make_unique<Process>(with_real_time_priority(command));
    EXPECT_TRUE(twin->says(": amplifier node")) << twin->err();
  }

  void start_controller(const std::vector<std::string>& options = {}) { start("controller", options); }
  /// Starts a subcommand on the controller's side of the wire and stores it in `controller`.
  void start(const char* subcommand, const std::vector<std::string>& options) {
    start(subcommand, options, config_);
  }
  void start(const char* subcommand, const std::vector<std::string>& options, const std::string& config) {
    std::vector<std::string> command{HYSTCAN_PROGRAM, subcommand, config, "--interface",
                                     wire_.controller_side};
    command.insert(command.end(), options.begin(), options.end());
    controller = std::make_unique<Process>(with_real_time_priority(command, controller_priority));
  }
  [[nodiscard]] bool tracks() { return controller->says("x: tracking") && controller->says("y: tracking"); }

  /// Decodes the present log (tests/hil/bus_log.h).
  json decoded() { return hil::decoded(log(), false); }
  json decoded_with_series() { return hil::decoded(log(), true); }

  /// Returns the log with all frames sent so far. candump writes in order, so a final marker frame follows
  /// them; the marker and all later frames are removed from the result.
  std::string log() {
    if (candump) {
      candump->send(SIGCONT);
      const std::string last = "7FE#0E4D";
      EXPECT_TRUE(shell(std::string("cansend ") + wire_.controller_side + " " + last));
      std::string all;
      EXPECT_TRUE(eventually([&] {
        all = support::read_file(log_file_);
        return all.find(" " + last + "\n") != std::string::npos;
      }));
      candump.reset();
      log_ = all.substr(0, all.rfind('\n', all.find(" " + last + "\n")) + 1);
    }
    return log_;
  }

  /// Returns every frame of the present log in candump's format, without time and interface:
  /// `201#4E61BC00010703D9`.
  std::vector<std::string> frames() {
    std::istringstream lines(log());
    std::vector<std::string> result;
    for (std::string line; std::getline(lines, line);) result.push_back(line.substr(line.rfind(' ') + 1));
    return result;
  }

  /// Stops the controller, expects this exit status, and returns the printed JSON.
  json stop_and_report(int status) {
    controller->send(SIGTERM);
    EXPECT_EQ(controller->wait(), status) << controller->err();
    return json::parse(controller->out());
  }

  std::unique_ptr<Process> candump;
  std::unique_ptr<Process> twin;
  std::unique_ptr<Process> controller;
  int controller_priority = priority;

 private:
  Wire wire_;
  std::string config_;
  std::string log_file_;
  std::string log_;
};

/// Expects that the log of x ends like after a stop: the drive ramped down, and the last command disabled the
/// amplifier.
inline void expect_stopped_by_a_ramp(const json& log) {
  EXPECT_EQ(log.at("last_command").at("enable"), 0);
  EXPECT_EQ(log.at("last_command").at("setpoint"), 0.0);
  EXPECT_NEAR(log.at("last_enabled_command").at("setpoint"), 0.0, 0.6) << "one cycle of 500 V/s";
  EXPECT_TRUE(log.at("first_fault").is_null());
}

}  // namespace hystcan::hil
