// Parses RTM_NEWLINK, the kernel's description of an interface (rtnetlink(7), linux/can/netlink.h).
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "can/socketcan/interface.h"

namespace hystcan::can {

/// `message` begins with its nlmsghdr. Empty if it is another message (an error: no such interface). The
/// parser skips attributes that are cut short or unknown.
std::optional<Interface> parse_link_message(std::span<const std::byte> message);

}  // namespace hystcan::can
