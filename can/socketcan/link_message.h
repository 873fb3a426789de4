// RTM_NEWLINK, the kernel's answer to "what is this interface" (rtnetlink(7), linux/can/netlink.h).
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "can/socketcan/interface.h"

namespace hystcan::can {

/// `message`: from its nlmsghdr on. Empty where it is another message (an error: no such interface).
/// Attributes that are cut short or unknown are passed over.
std::optional<Interface> parse_link_message(std::span<const std::byte> message);

}  // namespace hystcan::can
