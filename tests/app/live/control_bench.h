// A running controller for tests: the shipped two-axis stage in virtual time, which a thread advances, its
// control service, and clients with plain Unix sockets. Tests check answers and cycle records; the wall clock
// only ends a test that hangs. Any virtual time may pass between two steps of a test.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "app/live/control_service.h"
#include "app/live/cycle_outlets.h"
#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/patience.h"
#include "tests/support/shipped.h"

namespace hystcan::app {

/// Returns a connection to the Unix socket.
int connected_to(const std::filesystem::path& file);

/// A connection that sends and receives lines.
class Client {
 public:
  explicit Client(const std::filesystem::path& socket);
  ~Client() { hang_up(); }
  Client(Client&& other) noexcept : socket_(other.socket_), unread_(std::move(other.unread_)) {
    other.socket_ = -1;
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  Client& operator=(Client&&) = delete;

  void send(std::string_view bytes) const;
  /// Returns one answer; null if the other side has disconnected.
  nlohmann::json read();
  nlohmann::json ask(const nlohmann::json& command) {
    send(command.dump() + "\n");
    return read();
  }
  void end_sending();
  void hang_up();

 private:
  int socket_;
  std::string unread_;
};

/// The checked values of one cycle.
struct Step {
  std::uint64_t cycle = 0;
  controller::AxisState state = controller::AxisState::offline;
  double reference_um = 0.0;
  double position_um = 0.0;
  double drive = 0.0;
};

class ControlBench {
 public:
  /// `prepare` may edit the shipped files.
  explicit ControlBench(const std::function<void(const support::ShippedCopy&)>& prepare = {});
  ~ControlBench();
  ControlBench(const ControlBench&) = delete;
  ControlBench& operator=(const ControlBench&) = delete;

  Client client() const { return Client(socket()); }
  std::filesystem::path socket() const { return files_ / "control.sock"; }
  const support::ShippedCopy& files() const { return files_; }
  ControlService& service() { return *service_; }
  /// Ends the run, then the service, as the program does.
  void end_service();

  /// Waits until the axis is in this state; returns false after a timeout.
  bool axis_is(std::size_t axis, controller::AxisState state) const;
  /// Returns all cycles of an axis so far.
  std::vector<Step> steps(std::size_t axis) const;
  std::size_t step_count(std::size_t axis) const;
  bool asked_to_stop() const { return asked_to_stop_; }

 private:
  void run();
  void halt();

  support::ShippedCopy files_;
  config::Config config_;
  CycleOutlets outlets_;
  mutable std::mutex mutex_;
  std::vector<std::vector<Step>> steps_;
  rehearsal::Rehearsal rehearsal_;
  std::unique_ptr<ControlService> service_;
  std::atomic<bool> ending_{false};
  std::atomic<bool> asked_to_stop_{false};
  std::thread thread_;
};

/// Makes axis x follow its triangle for a day of virtual time. The shipped triangle lasts a second, which may
/// pass between two steps of a test.
void never_rest(const support::ShippedCopy& files);

/// Returns the largest change of the drive from one cycle to the next while tracking, from step `first` on.
double largest_drive_step(const std::vector<Step>& steps, std::size_t first);

bool says(const nlohmann::json& answer, std::string_view text);
bool is_ok(const nlohmann::json& answer);

}  // namespace hystcan::app
