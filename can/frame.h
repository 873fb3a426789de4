// One CAN frame as on the wire: identifier without flag bits, kind, payload.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace hystcan::can {

enum class FrameKind : std::uint8_t { data, remote, fd, error };

struct Frame {
  std::uint32_t id = 0;  ///< 11 bits, or 29 bits if `extended`
  bool extended = false;
  FrameKind kind = FrameKind::data;
  std::uint8_t length = 0;  ///< payload bytes: 0..8, or up to 64 if `kind` is fd
  std::array<std::uint8_t, 64> data{};

  std::span<std::uint8_t> payload() { return {data.data(), length}; }
  std::span<const std::uint8_t> payload() const { return {data.data(), length}; }

  friend bool operator==(const Frame&, const Frame&) = default;
};

}  // namespace hystcan::can
