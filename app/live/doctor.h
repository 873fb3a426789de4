// Checks whether this computer and its bus can run a configuration in real time. Each check has a figure that
// was found, a verdict and a cure.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "can/scheduler.h"
#include "config/schema/config.h"

namespace hystcan::app {

/// good      nothing to do
/// doubtful  the controller runs, but not as well as it could
/// bad       the controller does not run as configured
enum class Verdict : std::uint8_t { good, doubtful, bad };
std::string_view to_string(Verdict verdict);

struct Finding {
  std::string check;
  Verdict verdict = Verdict::good;
  std::string figure;
  std::string cure{};  ///< empty if the verdict is good
};

/// What the configuration asks for; the checks compare with it.
struct Demand {
  can::Duration period{};
  int priority = 0;  ///< 0: no real-time priority is asked for
  bool lock_memory = false;
  std::vector<std::int64_t> cpus;
  can::Duration lateness_trip{};  ///< zero: none
};
Demand demand_of(const controller::CommonConfig& config);

/// Parses a list such as "0-3,8", as /sys writes it; returns an empty set if the text is not a list.
std::set<std::int64_t> parse_cpu_list(std::string_view text);

/// Kernel, clock source, governors, idle states and processors, from /proc and /sys below `root`.
std::vector<Finding> examine_machine(const Demand& demand, const std::filesystem::path& root = "/");
/// The priority, locked memory and limits that this process can get, and its build type.
std::vector<Finding> examine_process(const Demand& demand);
/// Measures for `duration` how late the controller's kind of alarm comes, one in each period, on a thread
/// with the settings that the configuration asks for.
Finding examine_wake_up(const Demand& demand, can::Duration duration);
/// State, bit rate, restart, queue and error counters. Sends frames only if the interface is virtual or
/// `send` is true, and then measures how long a frame takes from one socket to another.
std::vector<Finding> examine_interface(const config::Config& config, const std::string& interface, bool send);

}  // namespace hystcan::app
