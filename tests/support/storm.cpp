#include "tests/support/storm.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <initializer_list>
#include <optional>
#include <random>
#include <span>
#include <utility>

namespace hystcan::support {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;
using Kind = controller::Request::Kind;

/// The causes to which a single trouble can lead, and the time after which it must be detected.
struct Expected {
  double detected_within_s = 0.0;
  std::vector<Cause> causes;
};

/// The times are those of docs/safety.md, or longer if they depend on the reference.
Expected expected_of(Trouble trouble) {
  using enum Cause;
  switch (trouble) {
    case Trouble::sample_lost:
    case Trouble::counter_frozen:
    case Trouble::sample_damaged:
      return {0.007, {sample_missing}};
    case Trouble::sensor_stopped:
    case Trouble::amplifier_stopped:
    case Trouble::foreign_write:
      return {0.0, {foreign_access}};
    case Trouble::forged_sample:
      return {0.002, {sample_doubled}};
    case Trouble::sensor_leaves:
      return {0.102, {node_not_operational}};
    case Trouble::statuses_lost:
      return {0.402, {status_missing}};
    case Trouble::sample_late:
      return {0.007, {sample_late, sample_missing}};
    case Trouble::sample_frozen:  // the sine has a turning point every quarter of a second
      return {0.5, {position_frozen, following_error, position_jumped}};
    case Trouble::sample_jumped:
      return {0.007, {position_jumped, following_error, position_implausible}};
    case Trouble::sample_beyond:
      return {0.003, {position_implausible}};
    case Trouble::sample_bad:
      return {0.003, {sensor_status}};
    case Trouble::sensor_emergency:
      return {0.0, {node_emergency}};
    case Trouble::sensor_unheard:
      return {0.303, {sensor_silent}};
    case Trouble::amplifier_unheard:
      return {0.303, {amplifier_silent}};
    case Trouble::amplifier_reset:
      return {0.0, {amplifier_not_enabled, node_restarted}};
    case Trouble::sensor_reset:
      return {0.0, {node_restarted}};
    case Trouble::amplifier_trips:
      return {0.013, {amplifier_fault}};
    case Trouble::commands_lost:  // with a shorter time the drive would return in one jump
      return {0.023,
              {amplifier_fault, node_emergency, position_jumped, position_implausible, following_error}};
    case Trouble::enable_lost:
      return {0.004, {amplifier_not_enabled, position_jumped, position_implausible, following_error}};
    case Trouble::bus_passive:
      return {0.053, {bus_passive}};
    case Trouble::bus_off:  // after a shorter time the controller would be error-passive for some 60 ms
      return {0.006, {bus_off, sample_missing, sample_late, cycle_overrun, bus_passive}};
    case Trouble::interface_down:
      return {0.003, {interface_down}};
    case Trouble::position_drifts:  // with a shorter time the position would return in one jump
      return {0.020, {following_error, position_jumped}};
    case Trouble::load_pulls:
      return {0.8, {saturated, following_error, position_jumped}};
    case Trouble::sync_late:
      return {0.004, {cycle_overrun}};
    case Trouble::stall:
      return {0.023, {cycle_overrun}};
    case Trouble::foreign_sync:
    case Trouble::foreign_heartbeat:
      return {0.0, {another_controller}};
    case Trouble::law_not_finite:
      return {0.006, {model_left_range}};
  }
  return {};
}

/// Returns true if the first trouble prevents the use of the frames that the second one changes.
bool hides(Trouble first, Trouble second) {
  using enum Trouble;
  const auto is = [](Trouble trouble, std::initializer_list<Trouble> kinds) {
    return std::ranges::find(kinds, trouble) != kinds.end();
  };
  if (first == commands_lost) return second == enable_lost;
  if (first == sensor_unheard) return second == sensor_leaves;  // only a heartbeat shows this state
  return is(first, {sample_lost, sample_late, sample_damaged, counter_frozen, sensor_stopped}) &&
         is(second, {sample_frozen, sample_jumped, sample_beyond, sample_bad});
}

class Storm {
 public:
  explicit Storm(const StormConfig& storm) : storm_(storm), random_(storm.seed), rig_(one_axis()) {
    result_.failures.reserve(kept);
    for (std::size_t i = 0; i < trouble_count; ++i) {
      expected_[i] = expected_of(static_cast<Trouble>(i));
      result_.by_trouble[i].within_ms = 1e3 * expected_[i].detected_within_s;
    }
  }

  StormResult run() {
    rig_.start();
    if (!rig_.tracks()) note_failure(result_.stuck, "did not start");
    while (now_s() < storm_.virtual_s) {
      episode();
      if (result_.resident_after_warm_up_kB == 0 && now_s() >= storm_.warm_up_s)
        result_.resident_after_warm_up_kB = resident_kB();
    }
    result_.resident_at_end_kB = resident_kB();
    result_.virtual_s = now_s();
    result_.cycles = rig_.controller().counters().cycles;
    result_.faults = rig_.faults();
    const WireMonitor& monitor = rig_.monitor();
    result_.commands = monitor.commands();
    result_.steepest = monitor.steepest();
    return result_;
  }

 private:
  static constexpr std::size_t kept = 12;
  static constexpr std::size_t at_once = 3;

  struct Drawn {
    Trouble trouble = Trouble::sample_lost;
    double begins_s = 0.0;  ///< since the beginning of the episode, like all times here
    double lasts_s = 0.0;
    std::optional<double> begun_s{};
    std::optional<double> ended_s{};
    double lasted_s() const { return *ended_s - *begun_s; }
  };

  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }
  double between(double low, double high) { return low + uniform() * (high - low); }
  double now_s() { return can::seconds(rig_.clock().now().time_since_epoch()); }
  void wait_s(double time_s) { rig_.run_for(can::Duration(std::llround(1e9 * time_s))); }
  const Expected& expected(Trouble trouble) const { return expected_[static_cast<std::size_t>(trouble)]; }

  TroubleCount& count_of(Trouble trouble) { return result_.by_trouble[static_cast<std::size_t>(trouble)]; }

  /// Draws the troubles of this episode: usually one, sometimes up to three at once, all of different kinds.
  std::span<Drawn> draw() {
    const double share = uniform();
    const std::size_t count = share < 0.7 ? 1 : share < 0.9 ? 2 : 3;
    std::size_t drawn = 0;
    while (drawn < count) {
      const auto trouble = static_cast<Trouble>(static_cast<std::size_t>(uniform() * trouble_count));
      const auto so_far = std::span(drawn_).first(drawn);
      if (std::ranges::any_of(so_far, [&](const Drawn& other) { return other.trouble == trouble; })) continue;
      drawn_[drawn++] = {.trouble = trouble,
                         .begins_s = count == 1 ? 0.0 : between(0.0, 0.05),
                         .lasts_s = 0.001 * std::pow(2000.0, uniform())};
      ++count_of(trouble).drawn;
    }
    return std::span(drawn_).first(drawn);
  }

  void episode() {
    ++result_.episodes;
    wait_s(between(0.75, 1.5));  // enabled for more than half a second, at any phase of the sine
    if (rig_.axis().state() != AxisState::tracking) {
      note_failure(result_.without_trouble, "between two episodes");
      recover();
    }
    const std::uint64_t faults_before = rig_.faults();
    const std::span<Drawn> troubles = draw();
    begun_s_ = now_s();
    run_troubles(troubles);
    wait_s(0.075);  // a late SYNC, a watchdog or an error counter may still lead to a fault
    judge(troubles, rig_.faults() != faults_before);
    recover();
    note_violations();
  }

  void run_troubles(std::span<Drawn> troubles) {
    while (std::ranges::any_of(troubles, [](const Drawn& one) { return !one.ended_s; })) {
      for (Drawn& one : troubles) {
        const double at_s = now_s() - begun_s_;
        if (!one.begun_s && at_s >= one.begins_s) {
          one.begun_s = at_s;
          rig_.begin(one.trouble);
        } else if (one.begun_s && !one.ended_s && at_s >= *one.begun_s + one.lasts_s) {
          one.ended_s = at_s;
          rig_.end(one.trouble);
        }
      }
      rig_.run_for(std::chrono::microseconds(500));
    }
  }

  /// Returns the longest continuous time in which frames show this trouble.
  static double visible_s(const Drawn& one, std::span<const Drawn> troubles) {
    double longest_s = one.lasted_s();
    for (const Drawn& other : troubles) {
      if (!hides(other.trouble, one.trouble)) continue;
      longest_s = std::min(longest_s, std::max(*other.begun_s - *one.begun_s, *one.ended_s - *other.ended_s));
    }
    return longest_s;
  }

  void judge(std::span<const Drawn> troubles, bool has_faulted) {
    const bool must = std::ranges::any_of(troubles, [&](const Drawn& one) {
      return visible_s(one, troubles) >= expected(one.trouble).detected_within_s;
    });
    result_.must_be_detected += must ? 1 : 0;
    in_words_ = in_words(troubles, has_faulted);
    if (must && !has_faulted) note_failure(result_.undetected, "undetected");
    if (!has_faulted) return;
    const Cause cause = rig_.axis().fault().cause;
    ++result_.by_cause[static_cast<std::size_t>(cause)];
    const auto& causes = expected(troubles.front().trouble).causes;
    if (troubles.size() == 1 && std::ranges::find(causes, cause) == causes.end())
      note_failure(result_.other_cause, "of another cause");
    note_safe_command(troubles, cause);
    if (troubles.size() > 1) return;
    TroubleCount& count = count_of(troubles.front().trouble);
    ++count.alone;
    if (!must) return;
    const double decided_s = can::seconds(rig_.decided_at().time_since_epoch()) - begun_s_;
    const double decided_ms = 1e3 * (decided_s - *troubles.front().begun_s);
    count.latest_ms = std::max(count.latest_ms, decided_ms);
    if (decided_ms > count.bound_ms()) note_failure(result_.late, "late");
  }

  /// Notes the time of the safe command, except if there is no bus to carry it or a late scheduler delays the
  /// next step.
  void note_safe_command(std::span<const Drawn> troubles, Cause cause) {
    const auto any_of = [&](std::initializer_list<Trouble> kinds) {
      return std::ranges::any_of(
          troubles, [&](const Drawn& one) { return std::ranges::find(kinds, one.trouble) != kinds.end(); });
    };
    if (any_of({Trouble::bus_off, Trouble::interface_down})) return;
    const bool between_steps = is_between_steps(cause);
    if (between_steps && any_of({Trouble::sync_late, Trouble::stall})) return;
    const double safe_ms = 1e3 * can::seconds(rig_.monitor().safe_since() - rig_.decided_at());
    SafeTime& worst = between_steps ? result_.between_steps : result_.in_a_step;
    if (safe_ms > worst.worst_ms) worst = {.worst_ms = safe_ms, .episode = in_words_};
  }

  /// Clears and enables the axis. If a trouble outlasts the first clear, the axis faults again; a second
  /// clear must then succeed.
  void recover() {
    for (int attempt = 0; attempt < 3; ++attempt) {
      if (rig_.axis().state() == AxisState::faulted) {
        wait_s(between(0.0, 0.3));
        rig_.ask(Kind::clear);
      }
      if (rig_.axis().state() == AxisState::offline) {
        wait_s(uniform() < 0.5 ? 0.0 : between(0.0, 0.2));
        rig_.ask(Kind::enable);
      }
      if (rig_.tracks()) return;
    }
    note_failure(result_.stuck, fmt::format("stuck {}", to_string(rig_.axis().state())));
  }

  void note_violations() {
    const WireMonitor& monitor = rig_.monitor();
    const std::uint64_t seen = std::exchange(violations_seen_, monitor.violations());
    const std::size_t described = std::exchange(described_, monitor.found().size());
    if (monitor.violations() == seen) return;
    note_failure(result_.unsafe, described < monitor.found().size() ? monitor.found()[described] : "unsafe");
  }

  /// Describes the troubles; times count from the beginning of the episode.
  std::string in_words(std::span<const Drawn> troubles, bool has_faulted) const {
    std::string text = fmt::format("episode at {:.4f} s", begun_s_);
    for (const Drawn& one : troubles)
      text += fmt::format(", {} {:.4f} to {:.4f} s", to_string(one.trouble), *one.begun_s, *one.ended_s);
    if (!has_faulted) return text + ", no fault";
    const auto after_begin_s = [&](can::Time time) {
      return can::seconds(time.time_since_epoch()) - begun_s_;
    };
    return text + fmt::format(", \"{}\" decided at {:.6f} s, safe since {:.6f} s",
                              to_string(rig_.axis().fault().cause), after_begin_s(rig_.decided_at()),
                              after_begin_s(rig_.monitor().safe_since()));
  }

  /// Counts a failure and keeps the description of the first few of each kind.
  void note_failure(std::uint64_t& counter, std::string_view what) {
    if (++counter <= kept)
      result_.failures.push_back(fmt::format("{:.4f} s: {}: {}", now_s(), what, in_words_));
  }

  StormConfig storm_;
  std::mt19937_64 random_;
  FaultRig rig_;
  std::array<Expected, trouble_count> expected_;
  std::array<Drawn, at_once> drawn_;
  double begun_s_ = 0.0;  ///< beginning of the latest episode
  std::string in_words_;  ///< description of the latest episode
  std::uint64_t violations_seen_ = 0;
  std::size_t described_ = 0;  ///< number of the monitor's violations that are already noted
  StormResult result_;
};

}  // namespace

std::int64_t resident_kB() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t size = 0;
  std::int64_t resident = 0;
  statm >> size >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

StormResult run_storm(const StormConfig& storm) { return Storm(storm).run(); }

void print(const StormResult& r) {
  std::printf("%.1f h of virtual time, %llu cycles, %llu commands on the wire, %llu episodes, %llu faults\n",
              r.virtual_s / 3600.0, static_cast<unsigned long long>(r.cycles),
              static_cast<unsigned long long>(r.commands), static_cast<unsigned long long>(r.episodes),
              static_cast<unsigned long long>(r.faults));
  std::printf(
      "must be detected %llu, undetected %llu, late %llu, of another cause %llu, without a trouble %llu, stuck %llu, "
      "with an unsafe frame %llu\n",
      static_cast<unsigned long long>(r.must_be_detected), static_cast<unsigned long long>(r.undetected),
      static_cast<unsigned long long>(r.late), static_cast<unsigned long long>(r.other_cause),
      static_cast<unsigned long long>(r.without_trouble), static_cast<unsigned long long>(r.stuck),
      static_cast<unsigned long long>(r.unsafe));
  std::printf("safe command at worst %.3f ms after the deciding frame: %s\n", r.in_a_step.worst_ms,
              r.in_a_step.episode.c_str());
  std::printf("  decided between two steps %.3f ms: %s\n", r.between_steps.worst_ms,
              r.between_steps.episode.c_str());
  std::printf("steepest step %.2f of the limit\n", r.steepest);
  std::printf("resident %lld kB after warm-up, %lld kB at the end\n",
              static_cast<long long>(r.resident_after_warm_up_kB),
              static_cast<long long>(r.resident_at_end_kB));
  for (std::size_t i = 0; i < r.by_cause.size(); ++i)
    if (r.by_cause[i] != 0)
      std::printf("  %8llu  %s\n", static_cast<unsigned long long>(r.by_cause[i]),
                  std::string(to_string(static_cast<controller::Cause>(i))).c_str());
  std::printf("  %-18s %8s %8s %12s %12s %12s\n", "trouble", "drawn", "alone", "lasts, ms", "latest, ms",
              "bound, ms");
  for (std::size_t i = 0; i < r.by_trouble.size(); ++i) {
    const TroubleCount& count = r.by_trouble[i];
    std::printf("  %-18s %8llu %8llu %12.3f %12.3f %12.3f\n",
                std::string(to_string(static_cast<Trouble>(i))).c_str(),
                static_cast<unsigned long long>(count.drawn), static_cast<unsigned long long>(count.alone),
                count.within_ms, count.latest_ms, count.bound_ms());
  }
  for (const std::string& failure : r.failures) std::printf("! %s\n", failure.c_str());
}

}  // namespace hystcan::support
