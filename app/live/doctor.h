// Checks whether this computer and its bus can run a configuration in real time. Each check returns the
// measured figure, a verdict and a cure.
#pragma once

#include <sched.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "can/frame.h"
#include "can/scheduler.h"
#include "config/schema/config.h"

namespace hystcan::app {

/// good      no action needed
/// doubtful  the controller runs, but worse than it could
/// bad       the controller does not run as configured
enum class Verdict : std::uint8_t { good, doubtful, bad };
constexpr auto words(Verdict) { return std::to_array<std::string_view>({"good", "doubtful", "bad"}); }
inline std::string_view to_string(Verdict verdict) {
  return words(verdict)[static_cast<std::size_t>(verdict)];
}

struct Finding {
  std::string check;
  Verdict verdict = Verdict::good;
  std::string figure;
  std::string cure{};  ///< empty if the verdict is good
};

/// Parses a list such as "0-3,8", as /sys writes it; returns an empty set if the text is not a list.
std::set<std::int64_t> parse_cpu_list(std::string_view text);

/// Returns the first line of a file of /proc or /sys; empty if it cannot be read.
std::string first_line(const std::filesystem::path& file);

/// Makes a finding from an error; the remedy of the error becomes the cure.
inline Finding refused(std::string check, Verdict verdict, const PlacedError& error) {
  return {std::move(check), verdict, error.finding(), error.advice().remedy};
}
/// Returns the verdict good, or doubtful with a cure.
inline Finding judged(std::string check, bool is_good, std::string figure, std::string cure) {
  if (is_good) return {std::move(check), Verdict::good, std::move(figure), {}};
  return {std::move(check), Verdict::doubtful, std::move(figure), std::move(cure)};
}

/// The scheduling policy and priority of a process.
struct SchedulingClass {
  int policy = 0;
  int priority = 0;
  bool is_realtime() const { return policy == SCHED_FIFO || policy == SCHED_RR; }
};
/// Returns, for example, "FIFO 45" or "not real-time".
std::string to_string(const SchedulingClass& scheduling);
/// Reads the class of a process. `process`: its folder in /proc.
SchedulingClass class_of(const std::filesystem::path& process);
/// Returns the value of a line in the file `status` of a process; empty if there is no such line. `process`:
/// its folder in /proc; `key`: for example "VmLck:".
std::string status_of(const std::filesystem::path& process, std::string_view key);

// Each check compares with the requirements of the configuration.

/// Checks kernel, clock source, governors, idle states and processors, from /proc and /sys below `root`.
std::vector<Finding> examine_machine(const controller::CommonConfig& config,
                                     const std::filesystem::path& root = "/");
/// Checks the priority, locked memory and limits that this process can get, and its build type.
std::vector<Finding> examine_process(const controller::CommonConfig& config);
/// Measures for `duration` how late alarms of the controller's kind expire: one alarm in each period, on a
/// thread with the configured settings.
Finding examine_wake_up(const controller::CommonConfig& config, can::Duration duration);
/// Checks the kernel's threads between the adapter of `interface` and the socket, from /proc and /sys below
/// `root`: NAPI should be threaded, its threads should have a priority above the controller's, and should run
/// on the processor of the interrupt.
Finding examine_receive_path(const controller::CommonConfig& config, const std::string& interface,
                             const std::filesystem::path& root = "/");
/// Checks the received frames of the configured messages against their format in the DBC: classical, CAN FD,
/// or CAN FD with bit-rate switch.
Finding examine_formats(const config::Config& config, std::span<const can::Frame> heard);
/// Checks state, bit rates, restart, queue, error counters and the format of the frames on the bus. Sends
/// frames only if the interface is virtual or `send` is true, to measure how long a frame takes from one
/// socket to another.
std::vector<Finding> examine_interface(const config::Config& config, const std::string& interface, bool send);
/// Checks the cards of [axis.analogue]: ranges, resolution, noise of the position, and time of a sample; also
/// scheduling class and locked memory of a running node. Writes no output and no line, and does not access
/// the cards of a running node.
std::vector<Finding> examine_analogue(const config::Config& config, const std::filesystem::path& root = "/");

}  // namespace hystcan::app
