#include "can/frame.h"

#include <algorithm>

namespace hystcan::can {

std::uint32_t arbitration_key(std::uint32_t id, bool extended, bool remote) {
  if (!extended) return id << 21U | std::uint32_t{remote} << 20U;
  return id >> 18U << 21U | std::uint32_t{3} << 19U | (id & 0x3FFFFU) << 1U | std::uint32_t{remote};
}

bool is_identifier(std::uint32_t id, bool extended) { return id <= (extended ? 0x1FFF'FFFFU : 0x7FFU); }

std::uint8_t wire_length(std::uint8_t message_length) {
  if (message_length <= 8) return message_length;
  return *std::ranges::lower_bound(fd_lengths, std::min<std::uint8_t>(message_length, 64));
}

FrameKind wire_kind(std::size_t message_length, bool fd) {
  return fd || message_length > 8 ? FrameKind::fd : FrameKind::data;
}

}  // namespace hystcan::can
