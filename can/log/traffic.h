// The traffic on a bus by message: number of frames, rate, jitter and rejections.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "can/log/candump.h"
#include "can/protocol/e2e.h"

namespace hystcan::can {

/// Statistics of the frames with one identifier.
struct MessageTraffic {
  const Message* message = nullptr;  ///< null if the database has no such message
  std::uint64_t count = 0;           ///< number of accepted and rejected frames
  std::array<std::uint64_t, rejection_count> rejected{};
  std::chrono::microseconds last{};
  std::optional<LoggedFrame> newest;  ///< the last accepted frame
  double rate_Hz = 0.0;               ///< frame rate in the last period
  /// Standard deviation of the intervals between accepted frames in the last statistics period, which ended
  /// with the last call of Traffic::end_period(); nullopt if this period had fewer than two intervals.
  std::optional<double> jitter_ms;
};

/// Counts the frames on a bus by message, and checks each frame against a database.
///
/// A message may have a counter and a CRC. The configuration defines them; for a message that the
/// configuration does not contain, the signals `Counter` and `Crc` define them if `Crc` is the last byte. An
/// E2eChecker checks the frames of such a message. For any other message, only kind and length of a frame are
/// checked. If a frame has the identifier of a message with an E2eChecker, but the wrong identifier type, it
/// counts for that message.
class Traffic {
 public:
  using Key = std::pair<bool, std::uint32_t>;  ///< true for a 29-bit identifier; the identifier itself

  /// The database must outlive this object. `configured`: the counter and CRC of messages, by message name.
  explicit Traffic(const Database& database, const Protections& configured = {});

  void add(const LoggedFrame& logged);
  /// Ends the present period. `period`: its length. Stores the rates and the jitter of this period in the
  /// members `rate_Hz` and `jitter_ms`.
  void end_period(std::chrono::duration<double> period);

  const std::map<Key, MessageTraffic>& messages() const { return messages_; }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t error_frames() const { return error_frames_; }
  double rate_Hz() const { return rate_Hz_; }
  /// Returns the state in the last error frame that contained a state; nullopt if there was none.
  std::optional<BusState> state() const { return state_; }
  std::optional<ErrorCounters> error_counters() const { return error_counters_; }

 private:
  /// Statistics of the intervals between the frames of one message since the start of the period.
  struct Period {
    std::uint64_t frames = 0;
    std::uint64_t intervals = 0;
    double mean_s = 0.0;
    double squares_s2 = 0.0;  ///< sum of squared deviations of the intervals from mean_s (Welford)
  };

  void add_error(const Frame& frame);
  std::optional<Rejection> check(const Key& key, const Message* message, const Frame& frame);

  const Database& database_;
  std::map<Key, MessageTraffic> messages_;
  std::map<Key, Period> periods_;
  std::map<Key, E2eChecker> checkers_;
  std::map<Key, const Message*> known_;
  std::uint64_t frames_ = 0;
  std::uint64_t error_frames_ = 0;
  std::uint64_t frames_of_period_ = 0;
  double rate_Hz_ = 0.0;
  std::optional<BusState> state_;
  std::optional<ErrorCounters> error_counters_;
};

}  // namespace hystcan::can
