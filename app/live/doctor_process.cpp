// The checks of `hystcan doctor` for this process: which priority and locked memory it can get, and how
// punctual its timers are.
#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>

#include <boost/asio/io_context.hpp>
#include <thread>

#include "app/live/doctor.h"
#include "app/live/realtime.h"
#include "can/socketcan/asio_scheduler.h"
#include "can/socketcan/socketcan_bus.h"
#include "controller/timing.h"

namespace hystcan::app {
namespace {

/// Limits of the timer lateness, as shares of the cycle period. Below `good_wake_up_share` the lateness
/// hardly affects the control loop. Above `bad_share_of_period` the cycle is lost.
constexpr double good_wake_up_share = 0.1;
constexpr double bad_share_of_period = 0.5;

constexpr int usual_priority = 45;  // lower than the interrupt threads of PREEMPT_RT, which have 50

/// Runs `work` on a new thread, because `work` changes scheduling settings that the calling thread must keep.
template <class Result, class Work>
Result on_a_thread(Work work) {
  Result result;
  std::thread([&] { result = work(); }).join();
  return result;
}

Finding examine_priority(const controller::Realtime& asked) {
  const int priority = asked.priority > 0 ? asked.priority : usual_priority;
  const auto refusal = on_a_thread<std::optional<RunError>>([priority] { return take_priority(priority); });
  if (refusal) return refused("priority", asked.priority > 0 ? Verdict::bad : Verdict::doubtful, *refusal);
  const bool is_given = asked.priority > 0 || sched_getscheduler(0) != SCHED_OTHER;
  return judged(
      "priority", is_given,
      fmt::format("SCHED_FIFO {} {}", priority, is_given ? "given" : "is available but not configured"),
      fmt::format("set priority = {} in [controller.realtime]", usual_priority));
}

Finding examine_memory(const controller::Realtime& asked) {
  if (const auto refusal = find_memory_lock_refusal())
    return refused("locked memory", asked.lock_memory ? Verdict::bad : Verdict::doubtful, *refusal);
  return judged("locked memory", asked.lock_memory,
                asked.lock_memory ? "can be locked" : "memory can be locked, but lock_memory is not set",
                "set lock_memory = true in [controller.realtime]");
}

std::string limit_text(int resource, rlim_t unit, const char* unit_name) {
  rlimit limit{};
  getrlimit(static_cast<__rlimit_resource>(resource), &limit);
  if (limit.rlim_cur == RLIM_INFINITY) return "unlimited";
  return fmt::format("{}{}", limit.rlim_cur / unit, unit_name);
}

Finding examine_limits() {
  rlimit time{};
  getrlimit(RLIMIT_RTTIME, &time);
  const bool endless = time.rlim_cur == RLIM_INFINITY;
  return judged("limits", endless,
                fmt::format("rtprio {}, memlock {}, rttime {}", limit_text(RLIMIT_RTPRIO, 1, ""),
                            limit_text(RLIMIT_MEMLOCK, 1024, " kB"), limit_text(RLIMIT_RTTIME, 1, " us")),
                "run ulimit -R unlimited (systemd: LimitRTTIME=infinity); "
                "the kernel kills a real-time thread that reaches rttime");
}

Finding examine_build() {
  const std::string type = HYSTCAN_BUILD_TYPE;
  const bool fast = type == "Release" || type == "RelWithDebInfo";
  return judged("build", fast, type.empty() ? "no build type" : type,
                "rebuild with cmake --preset release && cmake --build --preset release");
}

controller::TimeStatistics measure_wake_up(can::Duration period, can::Duration duration) {
  boost::asio::io_context context{1};
  can::AsioScheduler scheduler(context);
  controller::TimeStatistics lateness;
  can::Time deadline = scheduler.now() + period;
  const can::Time end = deadline + duration;
  std::unique_ptr<can::Timer> timer;
  timer = scheduler.make_timer([&] {
    const can::Time now = scheduler.now();
    lateness.add(now - deadline);
    while (deadline <= now) deadline += period;
    if (deadline < end) timer->expire_at(deadline);
  });
  timer->expire_at(deadline);
  context.run();
  return lateness;
}

}  // namespace

std::vector<Finding> examine_process(const controller::CommonConfig& config) {
  const controller::Realtime asked = config.realtime.value_or(controller::Realtime{});
  return {examine_build(), examine_priority(asked), examine_memory(asked), examine_limits()};
}

Finding examine_wake_up(const controller::CommonConfig& config, can::Duration duration) {
  const controller::Realtime asked = config.realtime.value_or(controller::Realtime{});
  const can::Duration period = controller::cycle_of(config);
  const auto lateness = on_a_thread<controller::TimeStatistics>([&] {
    if (!asked.cpus.empty()) keep_to_cpus(asked.cpus);  // ignores a refusal, because another check reports it
    if (asked.priority > 0) take_priority(asked.priority);
    return measure_wake_up(period, duration);
  });
  const controller::TimeSummary summary = lateness.summary();
  const double period_us = 1e6 * can::seconds(period);
  const double trip_us = 1e6 * can::seconds(config.lateness_trip);
  const bool trips = trip_us > 0.0 && summary.max_us > trip_us;
  std::string figure = fmt::format("p99 {:.0f} us, max {:.0f} us late in {} cycles of {:.0f} us",
                                   summary.p99_us, summary.max_us, summary.count, period_us);
  if (trips) figure += fmt::format(", more than wake_up_trip_us = {:.0f}", trip_us);
  Finding finding =
      judged("wake-up", !trips && summary.max_us <= good_wake_up_share * period_us, std::move(figure),
             "set priority and cpus in [controller.realtime], follow the advice above, stop other programs, "
             "or reduce rate_Hz");
  if (trips || summary.max_us > bad_share_of_period * period_us) finding.verdict = Verdict::bad;
  return finding;
}

}  // namespace hystcan::app
