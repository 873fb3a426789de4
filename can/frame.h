// One CAN frame: identifier, frame kind, payload. The flag bits of SocketCAN's identifier are separate
// members.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace hystcan::can {

enum class FrameKind : std::uint8_t { data, remote, fd, error };

/// Flags of an FD frame, with the values of linux/can.h. Bit-rate switch (BRS): the data phase uses the data
/// bit rate. Error state (ESI): the sender is error-passive.
inline constexpr std::uint8_t fd_bit_rate_switch = 1;
inline constexpr std::uint8_t fd_error_state = 2;

struct Frame {
  std::uint32_t id = 0;  ///< 11 bits, or 29 bits if `extended`
  bool extended = false;
  FrameKind kind = FrameKind::data;
  std::uint8_t length = 0;    ///< payload bytes: 0..8, or up to 64 if `kind` is fd
  std::uint8_t fd_flags = 0;  ///< used only if `kind` is fd: fd_bit_rate_switch, fd_error_state
  std::array<std::uint8_t, 64> data{};

  std::span<std::uint8_t> payload() { return {data.data(), length}; }
  std::span<const std::uint8_t> payload() const { return {data.data(), length}; }

  friend bool operator==(const Frame&, const Frame&) = default;
};

/// Returns the arbitration field as a number, with its bits in wire order. The frame with the lowest number
/// wins arbitration.
std::uint32_t arbitration_key(std::uint32_t id, bool extended, bool remote = false);

/// Returns true if the identifier fits into 11 bits, or into 29 bits if `extended`.
bool is_identifier(std::uint32_t id, bool extended);

/// The payload lengths of CAN FD above 8 bytes. Their length codes in the frame (DLC) are 9 to 15.
inline constexpr std::array<std::uint8_t, 7> fd_lengths{12, 16, 20, 24, 32, 48, 64};

/// Returns the payload bytes on the wire: a length of 0..8 is unchanged, a longer message is rounded up to
/// the next CAN FD length.
std::uint8_t wire_length(std::uint8_t message_length);

/// Returns the kind of frame that carries a message of this length: CAN FD if the message has more than 8
/// bytes or `fd` is true, else a classical data frame.
FrameKind wire_kind(std::size_t message_length, bool fd = false);

}  // namespace hystcan::can
