// Logs the health of the bus. The control thread takes the samples; another thread writes the lines.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "can/bus.h"

namespace hystcan::can {

/// Allows one line per period and counts the events in between. The caller supplies the time.
class RateLimit {
 public:
  explicit RateLimit(double period_s = 1.0) : period_s_(period_s) {}

  /// Adds the events up to `time_s`. Returns the number of events since the last line, suppressed events
  /// included; nullopt if no line is due.
  std::optional<std::uint64_t> add(std::uint64_t events, double time_s);

 private:
  double period_s_;
  std::optional<double> last_s_;
  std::uint64_t pending_ = 0;
};

struct BusReport {
  double time_s = 0.0;  ///< time since the start
  BusState state = BusState::active;
  Refusal refusal = Refusal::none;
  std::optional<ErrorCounters> error_counters;
  BusCounters counters;
};
static_assert(std::is_trivially_copyable_v<BusReport>, "reports cross threads by plain copying");

BusReport report_of(const Bus& bus, double time_s);
/// Combines the reports of several connections to one interface: sums of the frames that they sent, received
/// and lost; for error frames, which all connections receive, the largest count of each kind.
BusReport report_of(std::span<const Bus* const> connections, double time_s);

/// A counter of errors with its JSON key and its text.
struct BusTrouble {
  std::string_view key;
  std::string_view words;
  std::uint64_t BusCounters::*count;
};
std::span<const BusTrouble> bus_troubles();

/// Returns `bus active: 5210 frames sent, 8120 received`, then every trouble whose count is above 0.
std::string describe(const BusReport& report);

/// The control thread calls sample(), which neither waits nor allocates. One other thread calls write().
/// Each state and each trouble gives at most one line per second. The line contains the number of events
/// since the previous line.
class BusHealthLog {
 public:
  enum class Level : std::uint8_t { info, warning, error };
  using Sink = std::function<void(Level level, const std::string& line)>;

  BusHealthLog(std::string interface, Sink sink);
  ~BusHealthLog();

  void sample(const BusReport& report);
  void write();

 private:
  void write(const BusReport& report);

  static constexpr std::size_t logged_troubles = 8;  ///< the first 8 of bus_troubles(); the others are
                                                     ///< changes of state and have their own lines
  static constexpr std::size_t state_count = 5;

  struct Ring;  // keeps Boost's headers out of this header
  std::unique_ptr<Ring> ring_;
  std::string interface_;
  Sink sink_;
  BusReport last_;
  std::array<RateLimit, state_count> state_limits_;
  std::array<RateLimit, logged_troubles> trouble_limits_;
};

}  // namespace hystcan::can
