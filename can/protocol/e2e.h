// End-to-end protection of a message: a sequence counter, and an 8-bit CRC over a data id and the payload.
//
//   Crc = CRC-8 over  data id, payload bytes without the CRC's own
//
// | polynomial | poly | init | xorout | check value of "123456789" |
// |---|---|---|---|---|
// | SAE J1850 | 0x1D | 0xFF | 0xFF | 0x4B |
// | 8H2F, AUTOSAR | 0x2F | 0xFF | 0xFF | 0xDF |
//
// The data id: the identifier, low byte first (two bytes of a standard one, four of an extended one); or a
// number of two bytes, low byte first; or none. The counter runs through all values of its signal.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "can/dbc/signal_codec.h"
#include "can/frame.h"

namespace hystcan::can {

enum class Crc8 : std::uint8_t { sae_j1850, autosar_8h2f };
constexpr auto words(Crc8) { return std::to_array<std::string_view>({"SAE-J1850", "CRC-8H2F"}); }

std::uint8_t crc8_j1850(std::span<const std::uint8_t> bytes);
std::uint8_t crc8_8h2f(std::span<const std::uint8_t> bytes);

/// What the CRC covers before the payload.
struct DataId {
  enum class Kind : std::uint8_t { identifier, number, none };
  Kind kind = Kind::identifier;
  std::uint16_t number = 0;
};
constexpr auto words(DataId::Kind) {
  return std::to_array<std::string_view>({"identifier", "data_id", "payload"});
}

/// Where counter and CRC lie in a message; either may be missing. The CRC is a whole byte, wherever it
/// stands.
struct Protection {
  std::optional<SignalCodec> counter{};
  std::optional<SignalCodec> crc{};
  Crc8 polynomial = Crc8::sae_j1850;
  DataId data_id{};
};

/// By name of the message.
using Protections = std::map<std::string, Protection, std::less<>>;

/// The CRC of a frame, its place found once.
class CrcRule {
 public:
  explicit CrcRule(const Protection& protection);
  std::uint8_t operator()(const Frame& frame) const;

 private:
  std::size_t place_ = 0;  ///< of the CRC's byte
  Crc8 polynomial_;
  DataId data_id_;
};

/// Sender's side: stamps the next counter value and the CRC.
class E2eProtector {
 public:
  explicit E2eProtector(const Protection& protection) : protection_(protection), crc_of_(protection) {}
  void seal(Frame& frame);

 private:
  Protection protection_;
  CrcRule crc_of_;
  std::int64_t counter_ = 0;
};

/// Why a frame in the place of a message was not taken for it.
enum class Rejection : std::uint8_t { wrong_kind, extended_id, wrong_length, wrong_crc, repeated_counter };
inline constexpr std::size_t rejection_count = 5;

std::string_view to_string(Rejection rejection);

/// Payload bytes on the wire of a message of so many: 0..8 as they are; beyond, the next length that FD has
/// (12, 16, 20, 24, 32, 48, 64).
std::uint8_t wire_length(std::uint8_t message_length);

/// What a message of this length is sent as.
constexpr FrameKind wire_kind(std::size_t message_length) {
  return message_length > 8 ? FrameKind::fd : FrameKind::data;
}

/// Receiver's side: accepts a frame or says why not. Each cause has its own count.
class E2eChecker {
 public:
  /// `length`: the message's. `extended`: whether the message itself uses a 29-bit identifier.
  E2eChecker(const Protection& protection, std::uint8_t length, bool extended);

  /// Empty: the frame is sound. The checks run in the order of `Rejection`; the first that fails is counted.
  std::optional<Rejection> check(const Frame& frame);

  std::uint64_t rejected(Rejection cause) const { return rejected_[static_cast<std::size_t>(cause)]; }
  std::uint64_t accepted() const { return accepted_; }

  /// Forgets the last counter value: the next sound frame is accepted whatever its counter (a node has
  /// rebooted).
  void restart() { last_counter_.reset(); }

 private:
  bool repeats(const Frame& frame);

  Protection protection_;
  CrcRule crc_of_;
  std::uint8_t length_;
  FrameKind kind_;
  bool extended_;
  std::optional<std::int64_t> last_counter_;
  std::array<std::uint64_t, rejection_count> rejected_{};
  std::uint64_t accepted_ = 0;
};

/// What was rejected in the place of one message, by cause.
struct RejectedFrames {
  std::string message;
  std::array<std::uint64_t, rejection_count> by_cause{};
};
RejectedFrames rejected_frames(std::string message, const E2eChecker& checker);
/// "XAmpStatus: rejected: 3 wrong CRC, 1 repeated counter"; empty where there was none.
std::string describe(const RejectedFrames& rejected);

}  // namespace hystcan::can
