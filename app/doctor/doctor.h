// Whether this computer and its bus are fit to run a configuration in real time: a list of checks, each with
// what was found, a verdict and the cure.
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

/// good: nothing to do. doubtful: it runs, but not as well as it could. bad: it does not run as configured.
enum class Verdict : std::uint8_t { good, doubtful, bad };
std::string_view to_string(Verdict verdict);

struct Finding {
  std::string check;
  Verdict verdict = Verdict::good;
  std::string figure;
  std::string cure{};  ///< empty where it is good
};

/// What the checks are measured against.
struct Demand {
  can::Duration period{};
  int priority = 0;  ///< asked for; 0: not
  bool lock_memory = false;
  std::vector<std::int64_t> cpus;
  can::Duration wake_up_trip{};  ///< zero: none
};
Demand demand_of(const controller::CommonConfig& config);

/// "0-3,8" as /sys writes it. What is no such list is empty.
std::set<std::int64_t> parse_cpu_list(std::string_view text);

/// Kernel, clock source, governors, idle states, processors, as /proc and /sys below `root` tell.
std::vector<Finding> examine_machine(const Demand& demand, const std::filesystem::path& root = "/");
/// What this process may ask for: priority (tried), locked memory, limits; and how it was built.
std::vector<Finding> examine_process(const Demand& demand);
/// Alarms of the controller's own kind, one every period for `duration`, on a thread that has been given what
/// the configuration asks for.
Finding examine_wake_up(const Demand& demand, can::Duration duration);
/// State, bit rate, restart, queue, error counters. Where the interface is a virtual one, or `send`: how long
/// a frame takes from one socket to another. Nothing is sent otherwise.
std::vector<Finding> examine_interface(const config::Config& config, const std::string& interface, bool send);

}  // namespace hystcan::app
