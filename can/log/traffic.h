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

/// The frames of one identifier.
struct MessageTraffic {
  const Message* message = nullptr;  ///< null if the database has no such message
  std::uint64_t count = 0;           ///< accepted and rejected frames
  std::array<std::uint64_t, rejection_count> rejected{};
  std::chrono::microseconds last{};
  std::optional<LoggedFrame> newest;  ///< the last accepted frame
  double rate_Hz = 0.0;               ///< frame rate in the last period
  /// Standard deviation of the intervals between accepted frames in the last period; nullopt if fewer than
  /// two intervals.
  std::optional<double> jitter_ms;
};

/// Counts frames and compares them with a database. An E2eChecker checks each message with known protection:
/// from the configuration or, if it has none, from the signals `Counter` and `Crc` of our protocol (with the
/// CRC in the last byte). For any other message, only kind and length are checked. A frame with the
/// identifier of a checked message but the wrong identifier type counts for that message.
class Traffic {
 public:
  using Key = std::pair<bool, std::uint32_t>;  ///< extended, identifier

  /// The database must outlive this object. `configured` is the protection of each message, by message name.
  explicit Traffic(const Database& database, const Protections& configured = {});

  void add(const LoggedFrame& logged);
  /// Ends a period: rates and jitter are now the values of this period.
  void end_period(std::chrono::duration<double> period);

  const std::map<Key, MessageTraffic>& messages() const { return messages_; }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t error_frames() const { return error_frames_; }
  double rate_Hz() const { return rate_Hz_; }
  std::optional<BusState> state() const { return state_; }  ///< taken from the error frames
  std::optional<ErrorCounters> error_counters() const { return error_counters_; }

 private:
  /// Statistics of the intervals between frames since the start of the period.
  struct Period {
    std::uint64_t frames = 0;
    std::uint64_t intervals = 0;
    double mean_s = 0.0;
    double squares_s2 = 0.0;  ///< sum of squared deviations from the mean (Welford)
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
