// The check of `hystcan doctor` for the kernel threads that carry a frame from the adapter to the socket.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sched.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "app/live/doctor.h"
#include "base/text.h"

namespace hystcan::app {
namespace {

/// Recommended priority of the kernel threads that fetch received frames from the adapter (NAPI polling
/// threads). It is higher than the interrupt threads (50) and lower than the kernel's own threads (99).
constexpr int polling_priority = 80;

struct KernelThread {
  int pid = 0;
  std::string name;
  SchedulingClass scheduling{};
  std::string cpus{};  ///< processors on which the thread may run, for example "0-3"
};

/// Returns the kernel threads of an interface: interrupt threads named `irq/NN-can0` and polling threads
/// named `napi/can0-NN`. Does not find an interrupt thread that has another name, for example `irq/NN-spi0.0`
/// after the SPI bus of an adapter.
std::vector<KernelThread> threads_of(const std::string& interface, const std::filesystem::path& root) {
  std::vector<KernelThread> threads;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(root / "proc", none)) {
    const auto pid = parsed_number<int>(entry.path().filename().string());
    if (!pid) continue;
    KernelThread thread{.pid = *pid, .name = first_line(entry.path() / "comm")};
    const bool is_irq = thread.name.starts_with("irq/") && thread.name.ends_with("-" + interface);
    if (!is_irq && !thread.name.starts_with("napi/" + interface + "-")) continue;
    thread.scheduling = class_of(entry.path());
    thread.cpus = status_of(entry.path(), "Cpus_allowed_list:");
    threads.push_back(std::move(thread));
  }
  std::ranges::sort(threads, {}, &KernelThread::name);
  return threads;
}

std::string described(const KernelThread& thread) {
  return fmt::format("{} {} on {}", thread.name, to_string(thread.scheduling), thread.cpus);
}

}  // namespace

std::string to_string(const SchedulingClass& scheduling) {
  return scheduling.is_realtime() ? fmt::format("FIFO {}", scheduling.priority) : "not real-time";
}

/// Reads fields 40 (priority) and 41 (policy) of /proc/PID/stat, see proc(5). Field 2 is the process name in
/// parentheses, which may contain spaces, so the fields are counted from the last ")".
SchedulingClass class_of(const std::filesystem::path& process) {
  SchedulingClass found;
  const std::string stat = first_line(process / "stat");
  const auto name_end = stat.rfind(')');
  if (name_end == std::string::npos) return found;
  std::istringstream fields(stat.substr(name_end + 1));
  std::string skipped;
  for (int field = 3; field < 40; ++field) fields >> skipped;
  fields >> found.priority >> found.policy;
  return found;
}

std::string status_of(const std::filesystem::path& process, std::string_view key) {
  std::ifstream stream(process / "status");
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with(key)) continue;
    const auto begin = line.find_first_not_of(" \t", key.size());
    return begin == std::string::npos ? std::string() : line.substr(begin);
  }
  return {};
}

Finding examine_receive_path(const controller::CommonConfig& config, const std::string& interface,
                             const std::filesystem::path& root) {
  const std::filesystem::path network = root / "sys/class/net" / interface;
  std::error_code none;
  if (!std::filesystem::exists(network / "device", none))
    return {"receive path", Verdict::good, "none (virtual interface)"};
  const bool is_threaded = first_line(network / "threaded") == "1";
  const std::vector<KernelThread> threads = threads_of(interface, root);
  std::vector<std::string> figures{is_threaded ? "threaded NAPI" : "NAPI runs in the soft interrupt"};
  std::ranges::transform(threads, std::back_inserter(figures), described);

  const int own = config.realtime.value_or(controller::Realtime{}).priority;
  std::vector<std::string> cures;
  if (!is_threaded) cures.push_back(fmt::format("echo 1 > /sys/class/net/{}/threaded", interface));
  const auto irq =
      std::ranges::find_if(threads, [](const KernelThread& t) { return t.name.starts_with("irq/"); });
  for (const KernelThread& thread : threads) {
    if (!thread.scheduling.is_realtime() || thread.scheduling.priority <= own)
      cures.push_back(fmt::format("chrt -f -p {} {}", polling_priority, thread.pid));
    if (irq != threads.end() && thread.cpus != irq->cpus)
      cures.push_back(fmt::format("taskset -pc {} {}", irq->cpus, thread.pid));
  }
  if (!is_threaded)
    cures.push_back(
        fmt::format("then chrt -f -p {} PID for each thread napi/{}-*", polling_priority, interface));
  return judged("receive path", cures.empty(), fmt::format("{}", fmt::join(figures, ", ")),
                fmt::format("{}", fmt::join(cures, "; ")));
}

}  // namespace hystcan::app
