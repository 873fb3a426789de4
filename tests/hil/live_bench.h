// A twin and a controller as processes on real SocketCAN, and a bus log of the frames between them.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/support/process.h"

namespace hystcan::hil {

using nlohmann::json;
using std::chrono::milliseconds;
using support::Process;

inline const std::string config_file = HYSTCAN_SOURCE_DIR "/config/piezo.toml";

struct Wire {
  const char* controller_side;
  const char* twin_side;
};
inline void PrintTo(const Wire& wire, std::ostream* out) { *out << wire.controller_side; }

/// Runs the command with real-time scheduling (FIFO) if the user may, as for a real actuator.
inline std::vector<std::string> with_real_time_priority(std::vector<std::string> command,
                                                        const char* priority) {
  if (geteuid() == 0) command.insert(command.begin(), {"chrt", "--fifo", priority});
  return command;
}

inline bool shell(const std::string& command) { return std::system(command.c_str()) == 0; }

/// Makes vcan0 again before and after a test, whatever the test does to it.
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

/// Starts the twin and candump; a test starts the controller.
class LiveBench {
 public:
  explicit LiveBench(Wire wire, std::string config = config_file) : wire_(wire), config_(std::move(config)) {
    log_ = (std::filesystem::path(testing::TempDir()) / "hil.log").string();
    // -L prints the log format with the kernel's timestamps; the shell only opens the file.
    candump = std::make_unique<Process>(std::vector<std::string>{
        "sh", "-c", std::string("exec candump -L ") + wire.controller_side + " >" + log_});
    std::this_thread::sleep_for(milliseconds(200));
    // A real node has its own processor. The twin shares one with everything that the test starts, also with
    // the controller, which has the higher priority and does not wait for the twin.
    twin = std::make_unique<Process>(with_real_time_priority(
        {HYSTCAN_PROGRAM, "twin", config_, "--interface", wire.twin_side, "--force-interface"}, "40"));
    EXPECT_TRUE(twin->says("x: amplifier node")) << twin->err();
  }

  void start_controller(const std::vector<std::string>& options = {}) { start("controller", options); }
  /// Starts a subcommand on the controller's side of the wire; it becomes `controller`.
  void start(const char* subcommand, const std::vector<std::string>& options) {
    start(subcommand, options, config_);
  }
  void start(const char* subcommand, const std::vector<std::string>& options, const std::string& config) {
    std::vector<std::string> command{HYSTCAN_PROGRAM, subcommand, config, "--interface",
                                     wire_.controller_side};
    command.insert(command.end(), options.begin(), options.end());
    controller = std::make_unique<Process>(with_real_time_priority(command, "50"));
  }
  [[nodiscard]] bool tracks() { return controller->says("x: tracking") && controller->says("y: tracking"); }

  /// The log so far as an independent program decodes it; with every value of every axis for "--series".
  json decoded(const std::string& option = "") {
    std::this_thread::sleep_for(milliseconds(100));
    candump.reset();
    Process reader({"/usr/bin/python3", HYSTCAN_SOURCE_DIR "/tests/hil/decode.py", log_, option});
    EXPECT_EQ(reader.wait(), 0) << reader.err();
    return json::parse(reader.out());
  }

  /// Every frame of the log so far as candump writes it, without time and interface: `201#4E61BC00010703D9`.
  std::vector<std::string> frames() {
    std::this_thread::sleep_for(milliseconds(100));
    candump.reset();
    std::ifstream file(log_);
    std::vector<std::string> result;
    for (std::string line; std::getline(file, line);) result.push_back(line.substr(line.rfind(' ') + 1));
    return result;
  }

  /// Stops the controller, expects this exit status, and returns the JSON that it printed.
  json stop_and_report(int status) {
    controller->send(SIGTERM);
    EXPECT_EQ(controller->wait(), status) << controller->err();
    return json::parse(controller->out());
  }

  std::unique_ptr<Process> candump;
  std::unique_ptr<Process> twin;
  std::unique_ptr<Process> controller;

 private:
  Wire wire_;
  std::string config_;
  std::string log_;
};

}  // namespace hystcan::hil
