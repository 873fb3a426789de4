// The checks of `hystcan doctor`: can this computer and its bus run a configuration in real time? Each check
// returns a measured figure, a verdict and a remedy.
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

/// good      the user need not do anything
/// doubtful  the controller runs, but its timing could be better
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
  std::string cure{};  ///< what the user should do; empty if the verdict is good
};

/// Parses a list of processor numbers such as "0-3,8", the format of /sys. Returns an empty set if the text
/// is not such a list.
std::set<std::int64_t> parse_cpu_list(std::string_view text);

/// Returns the first line of a file in /proc or /sys; an empty text if the file cannot be read.
std::string first_line(const std::filesystem::path& file);

/// Converts an error to a finding. The remedy of the error becomes the cure of the finding.
inline Finding refused(std::string check, Verdict verdict, const PlacedError& error) {
  return {std::move(check), verdict, error.finding(), error.advice().remedy};
}
/// Returns the finding of a check that measured `figure`. The verdict is `good` if `is_good` is true.
/// Otherwise it is `doubtful`, and `cure` is what the user should do.
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
/// Formats the scheduling class, for example as "FIFO 45" or "not real-time".
std::string to_string(const SchedulingClass& scheduling);
/// Reads the scheduling class of a process. `process`: its folder in /proc, for example /proc/123.
SchedulingClass class_of(const std::filesystem::path& process);
/// Returns the value after `key` (for example "VmLck:") in the file `status` of a process; an empty text if
/// there is no such line. `process`: its folder in /proc, for example /proc/123.
std::string status_of(const std::filesystem::path& process, std::string_view key);

// The following checks compare the computer and the bus with the requirements of `config`.

/// Checks the kernel, its clock source, and the frequency governors and idle states of the processors. Reads
/// /proc and /sys below `root`, which tests replace.
std::vector<Finding> examine_machine(const controller::CommonConfig& config,
                                     const std::filesystem::path& root = "/");
/// Checks how this program was built, which real-time priority and how much locked memory this process can
/// get, and its resource limits.
std::vector<Finding> examine_process(const controller::CommonConfig& config);
/// Measures for `duration` how late timers expire. The timer is of the same kind as the controller's: one
/// expiry per cycle, on a thread with the configured real-time settings.
Finding examine_wake_up(const controller::CommonConfig& config, can::Duration duration);
/// Checks the kernel threads that carry a frame from the adapter of `interface` to the socket. NAPI, the
/// kernel's packet polling, should run in threads. These threads should have a higher priority than the
/// controller and run on the same processor as the adapter's interrupt. Reads /proc and /sys below `root`.
Finding examine_receive_path(const controller::CommonConfig& config, const std::string& interface,
                             const std::filesystem::path& root = "/");
/// Compares the frame format of received messages with the DBC. The format is classical CAN, CAN FD, or CAN
/// FD with bit-rate switch.
Finding examine_formats(const config::Config& config, std::span<const can::Frame> heard);
/// Checks the CAN interface: state, bit rates, restart time, transmit queue, error counters and the format of
/// received frames. If the interface is virtual or `send` is true, also sends test frames to measure the time
/// from one socket to another.
std::vector<Finding> examine_interface(const config::Config& config, const std::string& interface, bool send);
/// Checks the data acquisition cards of [axis.analogue]: ranges, resolution, position noise, and the duration
/// of one sample. If a node is already running, checks its scheduling class and locked memory instead, and
/// does not access its cards. Never writes an output or a digital line.
std::vector<Finding> examine_analogue(const config::Config& config, const std::filesystem::path& root = "/");

}  // namespace hystcan::app
