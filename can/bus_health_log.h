// What becomes of the bus, as lines of a log: sampled on the control thread, written on another.
#pragma once

#include <array>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "can/bus.h"

namespace hystcan::can {

/// Lets one line per period through and tells how many events it stands for. Told the time; holds no clock.
class RateLimit {
 public:
  explicit RateLimit(double period_s = 1.0) : period_s_(period_s) {}

  /// `events` more have happened by `time_s`. Empty: nothing to say, or not yet; else the events since the
  /// last line, the suppressed ones among them.
  std::optional<std::uint64_t> add(std::uint64_t events, double time_s);

 private:
  double period_s_;
  std::optional<double> last_s_;
  std::uint64_t pending_ = 0;
};

struct BusReport {
  double time_s = 0.0;  ///< since start
  BusState state = BusState::active;
  std::optional<ErrorCounters> error_counters;
  BusCounters counters;
};
static_assert(std::is_trivially_copyable_v<BusReport>, "reports cross threads by plain copying");

BusReport report_of(const Bus& bus, double time_s);
/// Of several nodes' connections to one interface. What they sent, heard and lost adds up; error frames are
/// heard by all alike, and the one that heard most counts.
BusReport report_of(std::span<const Bus* const> connections, double time_s);

/// A counter of things that should not be, under its key in JSON and in words.
struct BusTrouble {
  std::string_view key;
  std::string_view words;
  std::uint64_t BusCounters::*count;
};
std::span<const BusTrouble> bus_troubles();

/// `bus active: 5210 frames sent, 8120 received`, and every trouble that there was.
std::string describe(const BusReport& report);

/// sample() on the control thread, which neither waits nor allocates; write() on one other thread. Each
/// state entered and each trouble is at most one line a second, with the count since its last one.
class BusHealthLog {
 public:
  enum class Level : std::uint8_t { info, warning, error };
  using Sink = std::function<void(Level level, const std::string& line)>;

  BusHealthLog(std::string interface, Sink sink);

  void sample(const BusReport& report);
  void write();

 private:
  void write(const BusReport& report);

  static constexpr std::size_t capacity = 256;
  static constexpr std::size_t logged_troubles = 8;  ///< the first; the others are changes of state
  static constexpr std::size_t state_count = 5;

  boost::lockfree::spsc_queue<BusReport, boost::lockfree::capacity<capacity>> ring_;
  std::string interface_;
  Sink sink_;
  BusReport last_;
  std::array<RateLimit, state_count> state_limits_;
  std::array<RateLimit, logged_troubles> trouble_limits_;
};

}  // namespace hystcan::can
