// The checks that read /proc and /sys.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>

#include "app/live/doctor.h"

namespace hystcan::app {
namespace {

/// An idle state whose exit takes longer than this share of the period disturbs every cycle.
constexpr double idle_share = 0.05;

/// The first line of the file; empty if there is none.
std::string read_line(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

std::optional<std::int64_t> whole_number(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

Finding examine_kernel(const std::filesystem::path& root) {
  const std::string version = read_line(root / "proc/sys/kernel/version");
  const std::string kernel = read_line(root / "proc/sys/kernel/osrelease");
  const auto has = [&](std::string_view word) { return version.find(word) != std::string::npos; };
  if (read_line(root / "sys/kernel/realtime") == "1" || has("PREEMPT_RT"))
    return {.check = "kernel", .verdict = Verdict::good, .figure = kernel + ", PREEMPT_RT"};
  const char* model = has("PREEMPT_DYNAMIC") ? "PREEMPT_DYNAMIC"
                      : has("PREEMPT")       ? "PREEMPT"
                                             : "not preemptible";
  return {.check = "kernel",
          .verdict = Verdict::doubtful,
          .figure = fmt::format("{}, {}", kernel, model),
          .cure =
              "install a PREEMPT_RT kernel (Debian: linux-image-rt-amd64), or boot with preempt=full if "
              "the kernel is PREEMPT_DYNAMIC"};
}

Finding examine_clock(const std::filesystem::path& root) {
  std::string source = read_line(root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  const bool slow =
      source == "hpet" || source == "acpi_pm" || source == "jiffies" || source == "refined-jiffies";
  if (source.empty()) source = "not reported";
  if (!slow) return {.check = "clock source", .verdict = Verdict::good, .figure = source};
  return {.check = "clock source",
          .verdict = Verdict::doubtful,
          .figure = source + ": each reading is a system call",
          .cure = "see in dmesg why the kernel does not use the faster clock (tsc marked unstable?)"};
}

/// The processors on which the control thread may run: those configured, else all that are online.
std::set<std::int64_t> cpus_in_use(const Demand& demand, const std::filesystem::path& root) {
  if (!demand.cpus.empty()) return {demand.cpus.begin(), demand.cpus.end()};
  return parse_cpu_list(read_line(root / "sys/devices/system/cpu/online"));
}

std::filesystem::path folder_of(const std::filesystem::path& root, std::int64_t cpu) {
  return root / fmt::format("sys/devices/system/cpu/cpu{}", cpu);
}

Finding examine_governor(const Demand& demand, const std::filesystem::path& root) {
  std::set<std::string> governors;
  for (const std::int64_t cpu : cpus_in_use(demand, root))
    if (std::string governor = read_line(folder_of(root, cpu) / "cpufreq/scaling_governor");
        !governor.empty())
      governors.insert(std::move(governor));
  if (governors.empty())
    return {.check = "CPU governor",
            .verdict = Verdict::good,
            .figure = "none: the system cannot set the frequency"};
  const bool steady = governors == std::set<std::string>{"performance"};
  return {.check = "CPU governor",
          .verdict = steady ? Verdict::good : Verdict::doubtful,
          .figure = fmt::format("{}", fmt::join(governors, ", ")),
          .cure = steady ? "" : "cpupower frequency-set --governor performance"};
}

/// The longest exit latency of all enabled idle states.
std::optional<std::int64_t> deepest_idle_us(const std::filesystem::path& cpu) {
  std::optional<std::int64_t> deepest;
  std::error_code none;
  for (const auto& state : std::filesystem::directory_iterator(cpu / "cpuidle", none)) {
    if (read_line(state.path() / "disable") == "1") continue;
    if (const auto us = whole_number(read_line(state.path() / "latency"))) deepest = std::max(deepest, us);
  }
  return deepest;
}

Finding examine_idle_states(const Demand& demand, const std::filesystem::path& root) {
  std::optional<std::int64_t> deepest;
  for (const std::int64_t cpu : cpus_in_use(demand, root))
    deepest = std::max(deepest, deepest_idle_us(folder_of(root, cpu)));
  if (!deepest) return {.check = "C-states", .verdict = Verdict::good, .figure = "not reported"};
  const bool shallow = static_cast<double>(*deepest) <= idle_share * 1e6 * can::seconds(demand.period);
  return {.check = "C-states",
          .verdict = shallow ? Verdict::good : Verdict::doubtful,
          .figure = fmt::format("the deepest takes {} us to leave", *deepest),
          .cure = shallow ? ""
                          : "cpupower idle-set --disable-by-latency 10, or boot with processor.max_cstate=1"};
}

Finding examine_cpus(const Demand& demand, const std::filesystem::path& root) {
  const std::string isolated = read_line(root / "sys/devices/system/cpu/isolated");
  const std::string online = read_line(root / "sys/devices/system/cpu/online");
  const std::string shown = isolated.empty() ? "none" : isolated;
  if (demand.cpus.empty())
    return {
        .check = "processors",
        .verdict = isolated.empty() ? Verdict::good : Verdict::doubtful,
        .figure = fmt::format("online {}, isolated {}, cpus not set", online, shown),
        .cure = isolated.empty() ? "" : fmt::format("set cpus to isolated ones in [controller.realtime]")};
  const std::set<std::int64_t> there = parse_cpu_list(online);
  const std::set<std::int64_t> alone = parse_cpu_list(isolated);
  const auto all_in = [&](const std::set<std::int64_t>& set) {
    return std::ranges::all_of(demand.cpus, [&](std::int64_t cpu) { return set.contains(cpu); });
  };
  Finding finding{.check = "processors",
                  .verdict = Verdict::good,
                  .figure = fmt::format("cpus [{}], online {}, isolated {}", fmt::join(demand.cpus, ", "),
                                        online, shown)};
  if (!all_in(there)) {
    finding.verdict = Verdict::bad;
    finding.cure = "set cpus to processors that are online";
  } else if (!all_in(alone)) {
    finding.verdict = Verdict::doubtful;
    finding.cure =
        fmt::format("boot with isolcpus={}, so that nothing else runs there", fmt::join(demand.cpus, ","));
  }
  return finding;
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::good:
      return "good";
    case Verdict::doubtful:
      return "doubtful";
    case Verdict::bad:
      break;
  }
  return "bad";
}

Demand demand_of(const controller::CommonConfig& config) {
  Demand demand{.period = can::Duration(std::llround(1e9 / config.rate_Hz)),
                .priority = 0,
                .lock_memory = false,
                .cpus = {},
                .lateness_trip = config.lateness_trip};
  if (config.realtime) {
    demand.priority = config.realtime->priority;
    demand.lock_memory = config.realtime->lock_memory;
    demand.cpus = config.realtime->cpus;
  }
  return demand;
}

std::set<std::int64_t> parse_cpu_list(std::string_view text) {
  std::set<std::int64_t> cpus;
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), part.size() + 1));
    const auto dash = part.find('-');
    const auto first = whole_number(part.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : whole_number(part.substr(dash + 1));
    if (!first || !last || *last - *first >= controller::Realtime::cpus_max) return {};
    for (std::int64_t cpu = *first; cpu <= *last; ++cpu) cpus.insert(cpu);
  }
  return cpus;
}

std::vector<Finding> examine_machine(const Demand& demand, const std::filesystem::path& root) {
  return {examine_kernel(root), examine_clock(root), examine_governor(demand, root),
          examine_idle_states(demand, root), examine_cpus(demand, root)};
}

}  // namespace hystcan::app
