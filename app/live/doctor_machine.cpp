// The checks of `hystcan doctor` that read /proc and /sys.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <optional>

#include "app/live/doctor.h"
#include "base/text.h"

namespace hystcan::app {
namespace {

/// Maximum exit time of a processor idle state, as a share of the cycle period. A longer exit time would
/// delay every cycle, because the processor is idle between the cycles.
constexpr double idle_share = 0.05;

Finding examine_kernel(const std::filesystem::path& root) {
  const std::string version = first_line(root / "proc/sys/kernel/version");
  const std::string kernel = first_line(root / "proc/sys/kernel/osrelease");
  const auto has = [&](std::string_view word) { return version.find(word) != std::string::npos; };
  if (first_line(root / "sys/kernel/realtime") == "1" || has("PREEMPT_RT"))
    return {"kernel", Verdict::good, kernel + ", PREEMPT_RT"};
  const char* model = has("PREEMPT_DYNAMIC") ? "PREEMPT_DYNAMIC"
                      : has("PREEMPT")       ? "PREEMPT"
                                             : "not preemptible";
  return {"kernel", Verdict::doubtful, fmt::format("{}, {}", kernel, model),
          "install a PREEMPT_RT kernel (Debian: linux-image-rt-amd64), "
          "or boot with preempt=full if the kernel is PREEMPT_DYNAMIC"};
}

Finding examine_clock(const std::filesystem::path& root) {
  std::string source = first_line(root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  const bool slow =
      source == "hpet" || source == "acpi_pm" || source == "jiffies" || source == "refined-jiffies";
  if (source.empty()) source = "not reported";
  return judged("clock source", !slow,
                slow ? source + ": each reading of the time is a slow system call" : source,
                "find in dmesg why the kernel does not use a faster clock (example: tsc marked unstable)");
}

/// Returns the processors on which the control thread may run: the configured ones, or all online processors
/// if none is configured.
std::set<std::int64_t> cpus_in_use(const std::vector<std::int64_t>& configured,
                                   const std::filesystem::path& root) {
  if (!configured.empty()) return {configured.begin(), configured.end()};
  return parse_cpu_list(first_line(root / "sys/devices/system/cpu/online"));
}

std::filesystem::path folder_of(const std::filesystem::path& root, std::int64_t cpu) {
  return root / fmt::format("sys/devices/system/cpu/cpu{}", cpu);
}

Finding examine_governor(const std::vector<std::int64_t>& configured, const std::filesystem::path& root) {
  std::set<std::string> governors;
  for (const std::int64_t cpu : cpus_in_use(configured, root))
    if (std::string governor = first_line(folder_of(root, cpu) / "cpufreq/scaling_governor");
        !governor.empty())
      governors.insert(std::move(governor));
  if (governors.empty()) return {"CPU governor", Verdict::good, "none (the system cannot set the frequency)"};
  return judged("CPU governor", governors == std::set<std::string>{"performance"},
                fmt::format("{}", fmt::join(governors, ", ")),
                "cpupower frequency-set --governor performance");
}

/// Returns the exit time in us of the slowest enabled idle state of this processor; nullopt if there is none.
std::optional<std::int64_t> deepest_idle_us(const std::filesystem::path& cpu) {
  std::optional<std::int64_t> deepest;
  std::error_code none;
  for (const auto& state : std::filesystem::directory_iterator(cpu / "cpuidle", none)) {
    if (first_line(state.path() / "disable") == "1") continue;
    if (const auto us = parsed_number<std::int64_t>(first_line(state.path() / "latency")))
      deepest = std::max(deepest, us);
  }
  return deepest;
}

Finding examine_idle_states(const std::vector<std::int64_t>& configured, double rate_Hz,
                            const std::filesystem::path& root) {
  std::optional<std::int64_t> deepest;
  for (const std::int64_t cpu : cpus_in_use(configured, root))
    deepest = std::max(deepest, deepest_idle_us(folder_of(root, cpu)));
  if (!deepest) return {"C-states", Verdict::good, "not reported"};
  const bool shallow = static_cast<double>(*deepest) <= idle_share * 1e6 / rate_Hz;
  return judged("C-states", shallow, fmt::format("longest exit latency {} us", *deepest),
                "cpupower idle-set --disable-by-latency 10, or boot with processor.max_cstate=1");
}

Finding examine_cpus(const std::vector<std::int64_t>& configured, const std::filesystem::path& root) {
  const std::string isolated = first_line(root / "sys/devices/system/cpu/isolated");
  const std::string online = first_line(root / "sys/devices/system/cpu/online");
  const std::string shown = isolated.empty() ? "none" : isolated;
  if (configured.empty())
    return judged("processors", isolated.empty(),
                  fmt::format("online {}, isolated {}, cpus not set", online, shown),
                  "set cpus in [controller.realtime] to isolated processors");
  const std::set<std::int64_t> there = parse_cpu_list(online);
  const std::set<std::int64_t> alone = parse_cpu_list(isolated);
  const auto all_in = [&](const std::set<std::int64_t>& set) {
    return std::ranges::all_of(configured, [&](std::int64_t cpu) { return set.contains(cpu); });
  };
  const std::string figure =
      fmt::format("cpus [{}], online {}, isolated {}", fmt::join(configured, ", "), online, shown);
  if (!all_in(there))
    return {"processors", Verdict::bad, figure,
            "set cpus in [controller.realtime] to processors that are online"};
  return judged("processors", all_in(alone), figure,
                fmt::format("boot with isolcpus={}, so that no other process runs on them",
                            fmt::join(configured, ",")));
}

}  // namespace

std::string first_line(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

std::set<std::int64_t> parse_cpu_list(std::string_view text) {
  std::set<std::int64_t> cpus;
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), part.size() + 1));
    const auto dash = part.find('-');
    const auto first = parsed_number<std::int64_t>(part.substr(0, dash));
    const auto last =
        dash == std::string_view::npos ? first : parsed_number<std::int64_t>(part.substr(dash + 1));
    if (!first || !last || *last - *first >= controller::Realtime::cpus_max) return {};
    for (std::int64_t cpu = *first; cpu <= *last; ++cpu) cpus.insert(cpu);
  }
  return cpus;
}

std::vector<Finding> examine_machine(const controller::CommonConfig& config,
                                     const std::filesystem::path& root) {
  const std::vector<std::int64_t> configured = config.realtime.value_or(controller::Realtime{}).cpus;
  return {examine_kernel(root), examine_clock(root), examine_governor(configured, root),
          examine_idle_states(configured, config.rate_Hz, root), examine_cpus(configured, root)};
}

}  // namespace hystcan::app
