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

/// Limits a log to one line per period and counts the events between two lines. The caller supplies the time.
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
  double time_s = 0.0;  ///< time since the start of the run
  BusState state = BusState::active;
  Refusal refusal = Refusal::none;
  std::optional<ErrorCounters> error_counters;
  BusCounters counters;
};
static_assert(std::is_trivially_copyable_v<BusReport>,
              "a BusReport must be trivially copyable, because it crosses threads");

BusReport report_of(const Bus& bus, double time_s);
/// Combines the reports of several connections to one interface. Adds the numbers of frames that the
/// connections sent, received, did not send and lost. Takes the largest value of every other counter, because
/// each connection receives the same error frames.
BusReport report_of(std::span<const Bus* const> connections, double time_s);

/// A counter of errors with its JSON key and its text.
struct BusTrouble {
  std::string_view key;
  std::string_view words;
  std::uint64_t BusCounters::*count;
};
std::span<const BusTrouble> bus_troubles();

/// Returns a line such as `bus active: 5210 frames sent, 8120 received`. Each counter of errors that is above
/// 0 follows.
std::string describe(const BusReport& report);

/// Logs changes of the bus state and new errors. The control thread calls sample(), which neither waits nor
/// allocates memory. One other thread calls write(). Each bus state and each counter of errors gives at most
/// one line per second; the line contains the number of events since the previous line.
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

  /// The log has lines for the first 8 counters of bus_troubles() only. The other counters would repeat other
  /// lines: they count changes of state, which have their own lines, and error frames, whose causes are
  /// counted by the first 8.
  static constexpr std::size_t logged_troubles = 8;
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
