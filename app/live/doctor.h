// Checks whether this computer and its bus can run a configuration in real time. Each check has a figure that
// was found, a verdict and a cure.
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

/// good      nothing to do
/// doubtful  the controller runs, but not as well as it could
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

/// The first line of a file of /proc or /sys; empty if there is none.
std::string first_line(const std::filesystem::path& file);

/// The remedy of the error is the cure.
inline Finding refused(std::string check, Verdict verdict, const PlacedError& error) {
  return {std::move(check), verdict, error.finding(), error.advice().remedy};
}
/// Good, or doubtful with a cure.
inline Finding judged(std::string check, bool is_good, std::string figure, std::string cure) {
  if (is_good) return {std::move(check), Verdict::good, std::move(figure), {}};
  return {std::move(check), Verdict::doubtful, std::move(figure), std::move(cure)};
}

/// How the kernel schedules a process.
struct SchedulingClass {
  int policy = 0;
  int priority = 0;
  bool is_realtime() const { return policy == SCHED_FIFO || policy == SCHED_RR; }
};
/// "FIFO 45", "not real-time".
std::string to_string(const SchedulingClass& scheduling);
/// `process`: a folder of /proc.
SchedulingClass class_of(const std::filesystem::path& process);
/// The value of a line of the file `status` of a folder of /proc; `key`: "VmLck:". Empty if there is none.
std::string status_of(const std::filesystem::path& process, std::string_view key);

// The checks compare with what the configuration asks for.

/// Kernel, clock source, governors, idle states and processors, from /proc and /sys below `root`.
std::vector<Finding> examine_machine(const controller::CommonConfig& config,
                                     const std::filesystem::path& root = "/");
/// The priority, locked memory and limits that this process can get, and its build type.
std::vector<Finding> examine_process(const controller::CommonConfig& config);
/// Measures for `duration` how late the controller's kind of alarm comes, one in each period, on a thread
/// with the settings that the configuration asks for.
Finding examine_wake_up(const controller::CommonConfig& config, can::Duration duration);
/// The kernel's threads between the adapter of `interface` and the socket, from /proc and /sys below `root`:
/// is NAPI threaded, have its threads a priority above the controller's, and do they run on the interrupt's
/// processor?
Finding examine_receive_path(const controller::CommonConfig& config, const std::string& interface,
                             const std::filesystem::path& root = "/");
/// The frames that were heard with the identifiers of the configured messages, against the format that the
/// DBC gives them: classical, CAN FD, CAN FD with bit-rate switch.
Finding examine_formats(const config::Config& config, std::span<const can::Frame> heard);
/// State, bit rates, restart, queue, error counters and the format of the frames on the bus. Sends frames
/// only if the interface is virtual or `send` is true, and then measures how long a frame takes from one
/// socket to another.
std::vector<Finding> examine_interface(const config::Config& config, const std::string& interface, bool send);
/// The cards of [axis.analogue]: ranges, resolution, noise of the position, time of a sample; class and
/// locked memory of the node that runs. Writes no output and no line, and leaves the cards of a running
/// node alone.
std::vector<Finding> examine_analogue(const config::Config& config, const std::filesystem::path& root = "/");

}  // namespace hystcan::app
