// End-to-end protection of a message: a sequence counter, and a CRC over a data id and the payload.
//
//   Crc = CRC(data id, payload bytes without the CRC bytes)
//
//   | polynomial                   | poly   | init   | xorout | check value of "123456789" |
//   |------------------------------|--------|--------|--------|----------------------------|
//   | SAE J1850                    | 0x1D   | 0xFF   | 0xFF   | 0x4B                       |
//   | 8H2F, AUTOSAR                | 0x2F   | 0xFF   | 0xFF   | 0xDF                       |
//   | CRC-16, as AUTOSAR profile 5 | 0x1021 | 0xFFFF | 0x0000 | 0x29B1                     |
//
// docs/protocol/frames.md lists the number of bit errors that each CRC detects at each length.
//
// The data id has one of these kinds:
//
//   identifier   the CAN identifier, low byte first; two bytes for 11 bits, four bytes for 29 bits
//   number       a configured number of two bytes, low byte first
//   none         no data id: the CRC covers only the payload
//
// The counter runs through all values of its signal, then starts again at 0.
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

enum class Crc : std::uint8_t { sae_j1850, autosar_8h2f, crc16 };
constexpr auto words(Crc) { return std::to_array<std::string_view>({"SAE-J1850", "CRC-8H2F", "CRC-16"}); }
constexpr unsigned bytes_of(Crc crc) { return crc == Crc::crc16 ? 2 : 1; }
/// Returns the default CRC of a message of this length, in bytes.
constexpr Crc usual_crc(std::size_t length) { return length > 8 ? Crc::crc16 : Crc::sae_j1850; }
/// Returns the maximum length of a frame, in bytes without the CRC, at which the CRC detects every pair of
/// wrong bits. The bits of a longer frame and its CRC exceed the period of the polynomial (255, 127 or 32767
/// bits), so that the CRC does not detect some pairs of wrong bits.
constexpr unsigned most_bytes_guarded(Crc crc) {
  return std::array{30U, 14U, 4093U}[static_cast<std::size_t>(crc)];
}

std::uint8_t crc8_j1850(std::span<const std::uint8_t> bytes);
std::uint8_t crc8_8h2f(std::span<const std::uint8_t> bytes);
std::uint16_t crc16(std::span<const std::uint8_t> bytes);

/// The data id of a message: the CRC covers the bytes of the data id first, then the payload.
struct DataId {
  enum class Kind : std::uint8_t { identifier, number, none };
  Kind kind = Kind::identifier;
  std::uint16_t number = 0;
};
constexpr auto words(DataId::Kind) {
  return std::to_array<std::string_view>({"identifier", "data_id", "payload"});
}

/// The protection of a message: its signals for counter and CRC. Each of the two signals may be missing. The
/// CRC signal fills bytes_of(polynomial) whole bytes.
struct Protection {
  std::optional<SignalCodec> counter{};
  std::optional<SignalCodec> crc{};
  Crc polynomial = Crc::sae_j1850;
  DataId data_id{};

  /// Computes the CRC for the frame. The message must have a CRC signal.
  std::uint16_t crc_of(const Frame& frame) const;
};

/// The protection of messages (counter and CRC), by message name.
using Protections = std::map<std::string, Protection, std::less<>>;

/// Protects the frames of a sender: writes the next counter value and the CRC into each frame.
class E2eProtector {
 public:
  explicit E2eProtector(const Protection& protection) : protection_(protection) {}
  void seal(Frame& frame);
  /// Restarts the counter at 0.
  void restart() { counter_ = 0; }

 private:
  Protection protection_;
  std::int64_t counter_ = 0;
};

/// Why the receiver rejects a frame with the identifier of a message.
enum class Rejection : std::uint8_t { wrong_kind, extended_id, wrong_length, wrong_crc, repeated_counter };
inline constexpr std::size_t rejection_count = 5;

constexpr std::string_view to_string(Rejection rejection) {
  return std::to_array<std::string_view>({"not a data frame", "wrong identifier type", "wrong length",
                                          "wrong CRC",
                                          "repeated counter"})[static_cast<std::size_t>(rejection)];
}

/// Checks the frames of a receiver: accepts a frame or returns the reason for its rejection. Counts the
/// rejected frames by reason.
class E2eChecker {
 public:
  /// `length`: bytes of the message. `extended`: the message has a 29-bit identifier. `fd`: the message is
  /// CAN FD even if it has at most 8 bytes.
  E2eChecker(const Protection& protection, std::uint8_t length, bool extended, bool fd = false);

  /// Checks a frame. Returns nullopt if the frame is accepted, else the first failed check. The checks run in
  /// the order of the enumerators of `Rejection`.
  std::optional<Rejection> check(const Frame& frame);

  std::uint64_t rejected(Rejection cause) const { return rejected_[static_cast<std::size_t>(cause)]; }
  std::uint64_t accepted() const { return accepted_; }

  /// Clears the last counter value. Call after the sender restarted: its next frame may have any counter.
  void restart() { last_counter_.reset(); }

 private:
  bool repeats(const Frame& frame);

  Protection protection_;
  std::uint8_t length_;
  FrameKind kind_;
  bool extended_;
  std::optional<std::int64_t> last_counter_;
  std::array<std::uint64_t, rejection_count> rejected_{};
  std::uint64_t accepted_ = 0;
};

/// The rejected frames of one message, by reason.
struct RejectedFrames {
  std::string message;
  std::array<std::uint64_t, rejection_count> by_cause{};
};
RejectedFrames rejected_frames(std::string message, const E2eChecker& checker);
/// Returns a text such as "XAmpStatus: rejected: 3 wrong CRC, 1 repeated counter"; empty if no frame was
/// rejected.
std::string describe(const RejectedFrames& rejected);

}  // namespace hystcan::can
