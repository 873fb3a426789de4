#include "can/timing/chain.h"

#include <algorithm>

namespace hystcan::can {
namespace {

/// If frames of earlier cycles still wait after this number of cycles, the response time counts as unbounded.
constexpr int cycles_max = 100;

std::uint32_t priority_order(const ChainSource& source) {
  return arbitration_key(source.frame.id, source.frame.extended);
}

bool share_an_axis(const ChainSource& one, const ChainSource& other) {
  return std::ranges::find_first_of(one.axes, other.axes) != one.axes.end();
}

class Chain {
 public:
  /// `last`: the frame whose response time is computed. `sample`: the sample that arrives last of all samples
  /// that the command `last` waits for; null if `last` is not a command.
  Chain(std::span<const ChainSource> sources, const ChainSource* sample, const ChainSource& last,
        const ChainTiming& timing)
      : sources_(sources),
        sample_(sample),
        last_(last),
        timing_(timing),
        bit_(transmission_time({.nominal = 1}, timing.rates)),
        limit_((cycles_max + 1) * timing.cycle),
        of_slot_(timing.slots) {
    for (const ChainSource& source : sources) {
      if (owns(source) || shares_queue(source)) weakest_ = std::max(weakest_, priority_order(source));
      if (!source.slot) continue;
      Duration& longest = of_slot_.at(*source.slot);
      longest = std::max(longest, cost(source));
    }
  }

  std::optional<Duration> response() const {
    std::optional<Duration> worst = alone();
    for (int q = 1; worst; ++q) {
      const auto end = end_of_cycle(q - 1);
      if (!end || q > cycles_max) return std::nullopt;
      if (*end <= q * timing_.cycle) break;
      const auto begin = with_left_overs(q);
      if (!begin) return std::nullopt;
      worst = std::max(*worst, *begin - q * timing_.cycle);
    }
    if (worst) *worst += cost(last_);
    return worst;
  }

 private:
  /// Returns w(0) in chain.h: the latest time after SYNC at which the transmission of the last link of the
  /// chain begins, if all frames of the previous cycle were sent before SYNC.
  std::optional<Duration> alone() const {
    Duration own = last_.role == ChainRole::sync ? Duration::zero() : timing_.turnaround + in_slots(1);
    std::vector<const ChainSource*> before;
    std::vector<const ChainSource*> after;
    for (const ChainSource& source : sources_) {
      if (owns(source)) {
        if (&source != &last_) own += cost(source);
      } else if (!source.slot && !comes_after_last(source) && !is_of_controller(source.role)) {
        (priority_order(source) <= weakest_ ? before : after).push_back(&source);
      }
    }
    std::ranges::sort(after, std::ranges::greater{}, [this](const ChainSource* s) { return cost(*s); });
    return settle([&](Duration w) -> std::optional<Duration> {
      Duration next = own + blocking(after, w);
      for (const ChainSource* source : before) {
        const auto count = instances(*source, w);
        if (!count) return std::nullopt;
        next += *count * cost(*source);
      }
      return next;
    });
  }

  /// Returns L in chain.h: the longest time for which frames of lower priority than all links delay the
  /// chain. When a link is queued, the transmission of one such frame may have begun. One frame therefore
  /// counts for each link; the longest frames count. `after`: all frames of lower priority, the longest
  /// first. `window`: the time in which these frames are sent.
  Duration blocking(std::span<const ChainSource* const> after, Duration window) const {
    std::int64_t times = last_.role == ChainRole::sync ? 1 : last_.role == ChainRole::sample ? 2 : 3;
    Duration sum{};
    for (const ChainSource* source : after) {
      const std::int64_t taken = std::min(times, instances(*source, window).value_or(times));
      sum += taken * cost(*source);
      times -= taken;
    }
    return sum;
  }

  /// Returns w(q) in chain.h for q > 0: the latest time at which the transmission of the last link of the
  /// chain begins in the cycle after SYNC q. At each of the SYNCs 1 to q, frames of earlier cycles still
  /// wait.
  std::optional<Duration> with_left_overs(int q) const {
    const bool is_sync = last_.role == ChainRole::sync;
    const int answered = is_sync ? q : q + 1;
    const Duration own = answered * timing_.turnaround + in_slots(answered) - cost(last_);
    return settle([&](Duration w) {
      return with_all(own, q, w, [&](const ChainSource& source, std::int64_t count) {
        if (owns(source)) return std::int64_t{q + 1};
        return comes_after_last(source) ? std::min<std::int64_t>(count, q) : count;
      });
    });
  }

  /// Returns the latest time at which all frames of cycle q are sent: the commands, the controller's
  /// heartbeat, which is queued behind the commands, and the heartbeat or status of the node whose slot is
  /// this cycle.
  std::optional<Duration> end_of_cycle(int q) const {
    const Duration own = (q + 1) * timing_.turnaround + in_slots(q + 1);
    return settle([&](Duration w) {
      return with_all(own, q + 1, w, [&](const ChainSource& source, std::int64_t count) {
        return is_link(source.role) ? std::int64_t{q + 1} : count;
      });
    });
  }

  /// Returns D(cycles) in chain.h: the longest time that the frames in slots take in `cycles` consecutive
  /// cycles.
  Duration in_slots(int cycles) const {
    Duration greatest{};
    for (std::size_t first = 0; first < of_slot_.size(); ++first) {
      Duration sum{};
      for (std::size_t i = 0; i < static_cast<std::size_t>(cycles); ++i)
        sum += of_slot_[(first + i) % of_slot_.size()];
      greatest = std::max(greatest, sum);
    }
    return greatest;
  }

  /// Returns `own`, plus the transmission times of all frames without a slot in the time `window`. `own`: the
  /// part of the sum that the caller has already computed. Of the controller's axis statuses, at most
  /// `status_cycles` count: the controller sends one in each cycle. Any other frame counts
  /// times(source, count) times; `count` is the maximum number of frames of `source` in the time `window`.
  template <class Times>
  std::optional<Duration> with_all(Duration own, std::int64_t status_cycles, Duration window,
                                   Times times) const {
    Duration sum = own;
    std::int64_t statuses = 0;
    Duration longest_status{};
    for (const ChainSource& source : sources_) {
      if (source.slot) continue;
      const auto count = instances(source, window);
      if (!count) return std::nullopt;
      if (source.role == ChainRole::controller_status) {
        statuses += *count;
        longest_status = std::max(longest_status, cost(source));
      } else {
        sum += times(source, *count) * cost(source);
      }
    }
    return sum + std::min(statuses, status_cycles) * longest_status;
  }

  /// Solves the equation t = next(t) by iteration and returns its smallest solution. next(t) is the time that
  /// the chain needs if all frames that are queued before t are sent first; it must not decrease with t.
  /// Returns nullopt if t exceeds limit_ or if `next` returns nullopt.
  template <class Next>
  std::optional<Duration> settle(Next next) const {
    Duration value{};
    for (std::optional<Duration> following = next(value);; following = next(value)) {
      if (!following || *following > limit_) return std::nullopt;
      if (*following == value) return value;
      value = *following;
    }
  }

  bool owns(const ChainSource& source) const {
    return &source == &last_ || source.role == ChainRole::sync || &source == sample_;
  }

  /// Returns true if the last link of the chain is a command that may wait behind the frame `source` in the
  /// controller's queue.
  bool shares_queue(const ChainSource& source) const {
    if (last_.role != ChainRole::command) return false;
    return source.role == ChainRole::command || (source.slot && is_of_controller(source.role));
  }

  /// Returns true if the frame `source` answers the last link of the chain: samples and commands answer SYNC,
  /// and a command answers a sample of the same axis. An answer is sent after the link that it answers.
  /// Therefore only answers from earlier cycles can delay the last link.
  bool comes_after_last(const ChainSource& source) const {
    if (last_.role == ChainRole::sync) return is_link(source.role);
    return last_.role == ChainRole::sample && source.role == ChainRole::command &&
           share_an_axis(source, last_);
  }

  Duration cost(const ChainSource& source) const { return worst_transmission(source.frame, timing_.rates); }

  /// Returns n_k(window) in chain.h: the maximum number of frames of this source in the time `window`;
  /// nullopt if there is no maximum.
  std::optional<std::int64_t> instances(const ChainSource& source, Duration window) const {
    const bool is_status = source.role == ChainRole::controller_status;
    if (!source.response && !is_status) return std::nullopt;
    const Duration period = source.frame.period;
    const Duration from = is_link(source.role) ? Duration::zero()
                          : is_status          ? source.frame.jitter
                                               : *source.response;
    return (window + bit_ + from + period - Duration{1}) / period;
  }

  std::span<const ChainSource> sources_;
  const ChainSource* sample_;
  const ChainSource& last_;
  ChainTiming timing_;
  Duration bit_;
  Duration limit_;
  std::uint32_t weakest_ = 0;
  std::vector<Duration> of_slot_;  ///< transmission time of the longest frame in each slot
};

/// Sets the jitter of each frame that follows SYNC: the longest time from the start of its period until the
/// frame is queued. The jitter of a frame with a slot includes a whole round of slots: if the frame becomes
/// due just after its slot, it waits for the slot of the next round.
void set_jitter(std::span<ChainSource> sources, Duration sync_response, const ChainTiming& timing) {
  const Duration answered = sync_response + timing.turnaround;
  for (ChainSource& source : sources) {
    if (source.slot && !is_of_controller(source.role))
      source.frame.jitter = timing.slots * timing.cycle + answered;
    else if (source.role == ChainRole::sample || source.role == ChainRole::status)
      source.frame.jitter = answered;
    if ((source.role == ChainRole::sync || source.role == ChainRole::command) && source.response)
      source.frame.jitter = *source.response;
  }
}

/// Computes the response times of all frames except SYNC, samples and commands, with analyse(). Returns true
/// if a response time changed.
bool respond_to_jitter(std::span<ChainSource> sources, const BitRates& rates) {
  std::vector<PeriodicFrame> frames;
  frames.reserve(sources.size());
  for (const ChainSource& source : sources) frames.push_back(source.frame);
  const Schedule schedule = analyse(frames, rates);
  bool changed = false;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (is_link(sources[i].role)) continue;
    changed = changed || sources[i].response != schedule.frames[i].response;
    sources[i].response = schedule.frames[i].response;
  }
  return changed;
}

}  // namespace

std::optional<Duration> chain_response(std::span<const ChainSource> sources, const ChainSource& last,
                                       const ChainTiming& timing) {
  if (last.role != ChainRole::command) return Chain(sources, nullptr, last, timing).response();
  std::optional<Duration> worst;
  for (const ChainSource& sample : sources) {
    if (sample.role != ChainRole::sample || !share_an_axis(sample, last)) continue;
    const auto response = Chain(sources, &sample, last, timing).response();
    if (!response) return std::nullopt;
    worst = std::max(worst, response);
  }
  return worst;
}

void respond(std::span<ChainSource> sources, const ChainTiming& timing) {
  constexpr int rounds_max = 100;
  const auto sync = std::ranges::find(sources, ChainRole::sync, &ChainSource::role);
  for (int round = 0; round < rounds_max; ++round) {
    bool bounded = true;
    for (ChainSource& source : sources) {
      if (!is_link(source.role)) continue;
      source.response = chain_response(sources, source, timing);
      bounded = bounded && source.response;
    }
    if (!bounded) {
      respond_to_jitter(sources, timing.rates);
      return;
    }
    set_jitter(sources, *sync->response, timing);
    if (!respond_to_jitter(sources, timing.rates)) return;
  }
  for (ChainSource& source : sources)
    if (is_link(source.role)) source.response.reset();
}

}  // namespace hystcan::can
