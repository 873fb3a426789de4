#include "can/timing/schedulability.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace hystcan::can {
namespace {

constexpr unsigned error_frame_bits = 31;

/// A busy period longer than this limit counts as infinite. Only a bus load between 1 - 1e-6 and 1 can cause
/// such a period.
constexpr Duration endless = std::chrono::hours(1);

std::int64_t divide_up(std::int64_t value, std::int64_t by) { return (value + by - 1) / by; }

void check(std::span<const PeriodicFrame> frames) {
  for (const PeriodicFrame& frame : frames) {
    const auto refuse = [&](const std::string& what) {
      throw std::invalid_argument("frame " + frame.name + ": " + what);
    };
    if (frame.bytes > 64) refuse(std::to_string(frame.bytes) + " bytes, expected at most 64");
    if (!is_identifier(frame.id, frame.extended)) refuse("identifier too long for its type");
    if (frame.period <= Duration::zero()) refuse("the period must be above 0");
    if (frame.jitter < Duration::zero()) refuse("the jitter must not be negative");
    const auto same = [&](const PeriodicFrame& other) {
      return other.id == frame.id && other.extended == frame.extended;
    };
    if (std::ranges::count_if(frames, same) > 1) refuse("another frame has the same identifier");
  }
}

class Analysis {
 public:
  Analysis(std::span<const PeriodicFrame> frames, const BitRates& rates,
           std::optional<Duration> error_interval)
      : frames_(frames), rates_(rates), error_interval_(error_interval) {}

  Duration bits(unsigned count) const { return transmission_time({.nominal = count}, rates_); }
  Duration transmission(const PeriodicFrame& frame) const { return worst_transmission(frame, rates_); }
  double load_of(const PeriodicFrame& frame) const {
    return seconds(transmission(frame)) / seconds(frame.period);
  }

  FrameResponse respond(const PeriodicFrame& frame) {
    own_ = &frame;
    cost_ = transmission(frame);
    FrameResponse result{.transmission = cost_, .blocking = collect_others(), .response = {}};
    if (level_load_ >= 1.0) return result;
    const auto busy = settle(result.blocking, [&](Duration t) {
      return result.blocking + instances(t + frame.jitter, frame.period) * cost_ +
             interference(t, Duration::zero()) + recovery(t);
    });
    if (!busy) return result;
    const std::int64_t last = instances(*busy + frame.jitter, frame.period);
    Duration queued{};  // wait of the previous instance; the search for the next wait starts here
    for (std::int64_t q = 0; q < last; ++q) {
      const auto w = settle(std::max(queued, result.blocking + q * cost_), [&](Duration guess) {
        return result.blocking + q * cost_ + interference(guess, bits(1)) + recovery(guess + cost_);
      });
      if (!w) return result;
      queued = *w;
      const Duration response = frame.jitter + queued - q * frame.period + cost_;
      if (result.response && response <= *result.response) continue;
      result.response = response;
      result.instance = static_cast<std::uint64_t>(q);
    }
    result.schedulable = result.response && *result.response <= frame.deadline;
    return result;
  }

 private:
  /// Stores the frames of higher priority than own_ in higher_, and their load with own_ in level_load_.
  /// Stores in disturbance_ the time that one error takes: an error frame, and the repetition of the longest
  /// of these frames. Returns the longest transmission time of a frame of lower priority than own_.
  Duration collect_others() {
    higher_.clear();
    Duration blocking{};
    Duration longest = cost_;
    level_load_ = load_of(*own_);
    for (const PeriodicFrame& other : frames_) {
      if (&other == own_) continue;
      const Duration cost = transmission(other);
      if (arbitration_key(other.id, other.extended) > arbitration_key(own_->id, own_->extended)) {
        blocking = std::max(blocking, cost);
        continue;
      }
      higher_.emplace_back(&other, cost);
      longest = std::max(longest, cost);
      level_load_ += load_of(other);
    }
    disturbance_ = bits(error_frame_bits) + longest;
    if (error_interval_) level_load_ += seconds(disturbance_) / seconds(*error_interval_);
    return blocking;
  }

  static std::int64_t instances(Duration window, Duration period) {
    return divide_up(window.count(), period.count());
  }

  Duration interference(Duration window, Duration more) const {
    Duration sum{};
    for (const auto& [frame, cost] : higher_)
      sum += instances(window + frame->jitter + more, frame->period) * cost;
    return sum;
  }

  Duration recovery(Duration window) const {
    return error_interval_ ? instances(window, *error_interval_) * disturbance_ : Duration::zero();
  }

  /// Solves the equation t = next(t) by iteration from t = `from` and returns the smallest solution that is
  /// at least `from`. next(t) is the time that all frames need which are queued before t; it must not
  /// decrease with t. Returns nullopt if t exceeds `endless`.
  template <class Next>
  static std::optional<Duration> settle(Duration from, Next next) {
    Duration value = std::max(from, Duration{1});
    for (Duration following = next(value); following != value; following = next(value)) {
      if (following > endless) return std::nullopt;
      value = following;
    }
    return value;
  }

  std::span<const PeriodicFrame> frames_;
  BitRates rates_;
  std::optional<Duration> error_interval_;
  const PeriodicFrame* own_ = nullptr;
  Duration cost_{};
  Duration disturbance_{};
  double level_load_ = 0.0;
  /// The frames of higher priority than own_, each with its longest transmission time.
  std::vector<std::pair<const PeriodicFrame*, Duration>> higher_;
};

}  // namespace

BitCount worst_frame_bits(const PeriodicFrame& frame) {
  if (wire_kind(frame.bytes, frame.fd) == FrameKind::data) {
    constexpr unsigned tail = 13;  // bits from the CRC delimiter to the end of the interframe space
    const unsigned stuffed = (frame.extended ? 54 : 34) + 8 * frame.bytes;
    return {.nominal = stuffed + tail + (stuffed - 1) / 4};
  }
  // CAN FD: the bits before the bit-rate switch (BRS) have at most 3 stuff bits, or 7 with an extended
  // identifier. BRS differs from the reserved bit (res) before it. Equal bits before BRS therefore cause no
  // stuff bit after BRS. No stuff bit follows the last data bit, because a fixed stuff bit follows it anyway.
  const unsigned nominal = (frame.extended ? 36 + 7 : 17 + 3) + 12;
  const unsigned check = frame.bytes <= 16 ? 27 : 32;  // stuff count + CRC + fixed stuff bits
  const unsigned data = 5 + 8 * frame.bytes + (8 * frame.bytes + 4) / 4 + check + 1;
  if (!frame.bit_rate_switch) return {.nominal = nominal + data};
  return {.nominal = nominal, .data = data};
}

Duration worst_transmission(const PeriodicFrame& frame, const BitRates& rates) {
  return transmission_time(worst_frame_bits(frame), rates);
}

Schedule analyse(std::span<const PeriodicFrame> frames, const BitRates& rates,
                 std::optional<Duration> error_interval) {
  if (rates.nominal_bit_per_s == 0) throw std::invalid_argument("bit rate 0, expected more than 0");
  if (error_interval && *error_interval <= Duration::zero())
    throw std::invalid_argument("the error interval must be above 0");
  check(frames);
  Analysis analysis(frames, rates, error_interval);
  Schedule schedule;
  schedule.frames.reserve(frames.size());
  for (const PeriodicFrame& frame : frames) {
    schedule.frames.push_back(analysis.respond(frame));
    schedule.load += analysis.load_of(frame);
  }
  return schedule;
}

}  // namespace hystcan::can
