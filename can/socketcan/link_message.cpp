#include "can/socketcan/link_message.h"

// net/if.h comes first: then linux/if.h leaves out what both declare, also where Asio includes net/if.h later.
#include <net/if.h>

#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>

#include <algorithm>
#include <cstring>

namespace hystcan::can {
namespace {

using Bytes = std::span<const std::byte>;

template <class Value>
Value read_as(Bytes bytes) {
  Value value{};
  std::memcpy(&value, bytes.data(), std::min(sizeof value, bytes.size()));
  return value;
}

constexpr std::size_t aligned(std::size_t size) {
  return (size + NLMSG_ALIGNTO - 1) & ~(NLMSG_ALIGNTO - std::size_t{1});
}

template <class Visit>
void for_each_attribute(Bytes attributes, Visit visit) {
  while (attributes.size() >= sizeof(rtattr)) {
    const auto header = read_as<rtattr>(attributes);
    if (header.rta_len < sizeof(rtattr) || header.rta_len > attributes.size()) return;
    visit(header.rta_type & NLA_TYPE_MASK,
          attributes.subspan(sizeof(rtattr), header.rta_len - sizeof(rtattr)));
    attributes = attributes.subspan(std::min(aligned(header.rta_len), attributes.size()));
  }
}

std::string text_of(Bytes bytes) {
  std::string text(bytes.size(), '\0');
  std::memcpy(text.data(), bytes.data(), bytes.size());
  return text.substr(0, text.find('\0'));
}

std::optional<BusState> state_of(std::uint32_t can_state) {
  switch (can_state) {
    case CAN_STATE_ERROR_ACTIVE:
      return BusState::active;
    case CAN_STATE_ERROR_WARNING:
      return BusState::warning;
    case CAN_STATE_ERROR_PASSIVE:
      return BusState::passive;
    case CAN_STATE_BUS_OFF:
      return BusState::bus_off;
    default:  // stopped or sleeping: the interface is down
      return std::nullopt;
  }
}

void read_control_mode(std::uint32_t flags, Interface& interface) {
  interface.listen_only = (flags & CAN_CTRLMODE_LISTENONLY) != 0;
  interface.loopback = (flags & CAN_CTRLMODE_LOOPBACK) != 0;
  interface.one_shot = (flags & CAN_CTRLMODE_ONE_SHOT) != 0;
}

void read_can_attribute(int type, Bytes value, Interface& interface) {
  switch (type) {
    case IFLA_CAN_STATE:
      interface.bus_state = state_of(read_as<std::uint32_t>(value));
      return;
    case IFLA_CAN_BITTIMING: {
      const auto timing = read_as<can_bittiming>(value);
      if (timing.bitrate == 0) return;  // not configured
      interface.bitrate_bit_per_s = timing.bitrate;
      interface.sample_point = timing.sample_point / 1000.0;
      return;
    }
    case IFLA_CAN_RESTART_MS:
      interface.restart_ms = read_as<std::uint32_t>(value);
      return;
    case IFLA_CAN_CTRLMODE: {
      const auto mode = read_as<can_ctrlmode>(value);
      read_control_mode(mode.flags, interface);
      return;
    }
    case IFLA_CAN_BERR_COUNTER: {
      const auto counters = read_as<can_berr_counter>(value);
      interface.error_counters = ErrorCounters{.transmit = counters.txerr, .receive = counters.rxerr};
      return;
    }
    default:
      return;
  }
}

void read_statistics(Bytes value, Interface& interface) {
  const auto driver = read_as<can_device_stats>(value);
  interface.driver_statistics = {.bus_errors = driver.bus_error,
                                 .warnings = driver.error_warning,
                                 .passives = driver.error_passive,
                                 .bus_offs = driver.bus_off,
                                 .arbitration_lost = driver.arbitration_lost,
                                 .restarts = driver.restarts};
}

/// IFLA_INFO_KIND decides the meaning of IFLA_INFO_DATA and may come after it.
void read_link_info(Bytes info, Interface& interface) {
  Bytes data;
  Bytes statistics;
  for_each_attribute(info, [&](int type, Bytes value) {
    if (type == IFLA_INFO_KIND) interface.kind = text_of(value);
    if (type == IFLA_INFO_DATA) data = value;
    if (type == IFLA_INFO_XSTATS) statistics = value;
  });
  if (interface.kind != "can") return;
  for_each_attribute(data, [&](int type, Bytes value) { read_can_attribute(type, value, interface); });
  if (!statistics.empty()) read_statistics(statistics, interface);
}

}  // namespace

std::optional<Interface> parse_link_message(Bytes message) {
  constexpr std::size_t link_at = aligned(sizeof(nlmsghdr));
  constexpr std::size_t attributes_at = link_at + aligned(sizeof(ifinfomsg));
  if (message.size() < attributes_at || read_as<nlmsghdr>(message).nlmsg_type != RTM_NEWLINK)
    return std::nullopt;
  const auto link = read_as<ifinfomsg>(message.subspan(link_at));
  Interface interface;
  interface.index = link.ifi_index;
  interface.up = (link.ifi_flags & IFF_UP) != 0;
  interface.is_can = link.ifi_type == ARPHRD_CAN;
  for_each_attribute(message.subspan(attributes_at), [&](int type, Bytes value) {
    if (type == IFLA_LINKINFO) read_link_info(value, interface);
    if (type == IFLA_QDISC) interface.queue_discipline = text_of(value);
    if (type == IFLA_MTU) interface.fd = read_as<std::uint32_t>(value) >= CANFD_MTU;
    if (type == IFLA_TXQLEN) interface.transmit_queue_frames = read_as<std::uint32_t>(value);
  });
  return interface;
}

}  // namespace hystcan::can
