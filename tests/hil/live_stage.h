// A twin on vcan0 with its own configuration, which a test may change; a controller that accepts commands;
// and the values of the axes as sent on the wire.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/hil/live_bench.h"

namespace hystcan::hil {

/// A value from a message of an axis, with the kernel's time of arrival.
struct OnWire {
  double time_s = 0.0;
  double value = 0.0;  ///< Output, Setpoint or Position
  int byte4 = 0;       ///< State of AmpStatus, flags of AmpCommand, SyncCounter of SensorSample
};

inline std::vector<OnWire> series(const json& log, const char* axis, const char* message) {
  std::vector<OnWire> result;
  const json& rows = log.at("series").at(axis).at(message);
  result.reserve(rows.size());
  for (const json& row : rows) result.push_back({row[0], row[1], row[2]});
  return result;
}

inline std::vector<OnWire> between(const std::vector<OnWire>& all, double from_s, double to_s) {
  std::vector<OnWire> part;
  std::ranges::copy_if(all, std::back_inserter(part),
                       [&](const OnWire& one) { return one.time_s >= from_s && one.time_s < to_s; });
  return part;
}

/// Returns the time of day, the clock of candump.
inline double now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

constexpr int amp_enabled = 2;

/// Expects that in their last statuses both amplifiers are disabled, at their safe value, 0 V. With the
/// bandwidth of 1500 Hz, 100 V fall below a millivolt some milliseconds after they are switched off.
inline void expect_both_safe(const json& log) {
  for (const char* axis : {"X", "Y"}) {
    const std::vector<OnWire> statuses = series(log, axis, "AmpStatus");
    ASSERT_FALSE(statuses.empty()) << axis;
    EXPECT_NE(statuses.back().byte4, amp_enabled) << axis;
    EXPECT_NEAR(statuses.back().value, 0.0, 1e-3) << axis;
  }
}

/// A client of the control socket that stays connected. Tests that send many requests use it, because
/// starting a `hystcan ctl` process for each request is slow on an emulated processor.
class Client {
 public:
  explicit Client(const std::string& file) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    file.copy(address.sun_path, sizeof address.sun_path - 1);
    is_connected_ = connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    support::limit_receive(socket_);
  }
  ~Client() { close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  bool is_connected() const { return is_connected_; }
  /// Sends the text and returns the line of the answer; null if the answer is not JSON.
  json says(const std::string& text) const {
    EXPECT_EQ(send(socket_, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
    std::string line;
    for (char letter = 0; recv(socket_, &letter, 1, 0) == 1 && letter != '\n';) line += letter;
    const json answer = json::parse(line, nullptr, false);
    return answer.is_discarded() ? json() : answer;
  }

 private:
  int socket_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  bool is_connected_ = false;
};

struct LiveStage {
  support::ShippedCopy files;
  FreshVcan fresh;
  std::string config = (files / "piezo.toml").string();
  std::string socket = (files / "ctl.sock").string();
  LiveBench bench{{"vcan0", "vcan0"}, config};

  // The wipe of the start-up takes 0.2 s instead of 0.6 s, because these tests start often.
  LiveStage() {
    edit_both_axes("wipe_slew_V_per_s  = 500.0", "wipe_slew_V_per_s  = 2_000.0");
    edit_both_axes("wipe_dwell_s       = 0.1", "wipe_dwell_s       = 0.05");
    set("controller", "control_socket = \"" + socket + "\"\nblack_box_dir = \"" + folder() + "\"");
  }

  void edit_both_axes(const std::string& as_shipped, const std::string& here) const {
    files.edit("piezo.toml", as_shipped, here);
    files.edit("piezo.toml", as_shipped, here);
  }

  std::string folder() const { return std::filesystem::path(config).parent_path().string(); }

  /// Adds a line to the first [table] or [[table]] with that name.
  void set(const std::string& table, const std::string& line) const {
    files.edit("piezo.toml", "[" + table + "]\n", "[" + table + "]\n" + line + "\n");
  }

  void start(const std::vector<std::string>& options = {}) {
    bench.start_controller(options);
    ASSERT_TRUE(bench.tracks()) << bench.controller->err();
  }

  /// Returns the log including some time after the controller's end. AmpStatus is sent at every tenth SYNC:
  /// ten more SYNCs make the amplifiers send their present output.
  json log_at_rest() {
    std::this_thread::sleep_for(milliseconds(100));
    EXPECT_TRUE(shell("for i in 1 2 3 4 5 6 7 8 9 10; do cansend vcan0 080#01; done"));
    return bench.decoded_with_series();
  }

  struct Answer {
    int status = 0;
    std::string out;
    std::string err;
  };
  Answer ctl(const std::vector<std::string>& words) const { return ask({"--socket", socket}, words); }
  /// Sends the command to the twin instead of the controller.
  Answer ctl_twin(const std::vector<std::string>& words) const { return ask({"--twin"}, words); }
  /// Returns the controller's answer to `status`; null if no controller is listening.
  json status() const {
    const Client client(socket);
    return client.is_connected() ? client.says("{\"do\": \"status\"}\n") : json();
  }
  json axis_status(std::size_t axis) const {
    const json answer = status();
    EXPECT_TRUE(answer.is_object()) << "no status of the controller";
    return answer.is_object() ? answer.at("axes").at(axis) : json::object();
  }
  bool reaches(std::size_t axis, const std::string& state) const {
    return eventually([&] { return axis_status(axis).value("state", "") == state; });
  }

 private:
  static Answer ask(const std::vector<std::string>& target, const std::vector<std::string>& words) {
    std::vector<std::string> command{HYSTCAN_PROGRAM, "ctl"};
    command.insert(command.end(), target.begin(), target.end());
    command.insert(command.end(), words.begin(), words.end());
    Process process(command);
    const int status = process.wait();
    return {status, process.out(), process.err()};
  }
};

/// A stage at half the rate, for tests that do not concern timing: each cycle is expensive for an emulated
/// processor.
struct QuickStage : LiveStage {
  QuickStage() {
    files.edit("piezo.toml", "rate_Hz = 1000.0", "rate_Hz = 500.0");
    edit_both_axes("command_delay_us       = 1000.0", "command_delay_us       = 2000.0");
    edit_both_axes("ki_per_s           = 409.0", "ki_per_s           = 200.0");
    edit_both_axes("\nslew_V_per_s       = 20_000.0", "\nslew_V_per_s       = 10_000.0");
  }
};

}  // namespace hystcan::hil
