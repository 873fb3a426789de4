// End-to-end protection of a message: a 4-bit sequence counter and a CRC over identifier and payload.
//
//   Crc = CRC-8/SAE-J1850 (poly 0x1D, init 0xFF, xorout 0xFF) over
//         identifier low byte, identifier high byte, payload bytes 0..6
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "can/codec.h"
#include "can/frame.h"

namespace hystcan::can {

std::uint8_t crc8_j1850(std::span<const std::uint8_t> bytes);

/// Where counter and CRC lie in a message. The CRC covers every payload byte but the last, which it is.
struct Protection {
  SignalCodec counter;
  SignalCodec crc;
};

/// Sender's side: stamps the next counter value and the CRC.
class Sealer {
 public:
  explicit Sealer(Protection protection) : protection_(protection) {}
  void seal(Frame& frame);

 private:
  Protection protection_;
  std::uint8_t counter_ = 0;
};

/// Why a frame in the place of a message was not taken for it.
enum class Rejection : std::uint8_t { wrong_kind, extended_id, wrong_length, wrong_crc, repeated_counter };
inline constexpr std::size_t rejection_count = 5;

std::string_view to_string(Rejection rejection);

/// Receiver's side: accepts a frame or says why not. Each cause has its own count.
class Checker {
 public:
  /// `extended`: whether the message itself uses a 29-bit identifier.
  Checker(Protection protection, std::uint8_t length, bool extended);

  /// Empty: the frame is sound. The checks run in the order of `Rejection`; the first that fails is counted.
  std::optional<Rejection> check(const Frame& frame);

  std::uint64_t rejected(Rejection cause) const { return rejected_[static_cast<std::size_t>(cause)]; }
  std::uint64_t accepted() const { return accepted_; }

  /// Forgets the last counter value: the next sound frame is accepted whatever its counter (a node has
  /// rebooted).
  void restart() { last_counter_.reset(); }

 private:
  Protection protection_;
  std::uint8_t length_;
  bool extended_;
  std::optional<std::int64_t> last_counter_;
  std::array<std::uint64_t, rejection_count> rejected_{};
  std::uint64_t accepted_ = 0;
};

}  // namespace hystcan::can
