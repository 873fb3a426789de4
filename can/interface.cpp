#include "can/interface.h"

#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "can/socketcan_bus.h"

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

BusState state_of(std::uint32_t can_state) {
  switch (can_state) {
    case CAN_STATE_ERROR_WARNING:
      return BusState::warning;
    case CAN_STATE_ERROR_PASSIVE:
      return BusState::passive;
    case CAN_STATE_BUS_OFF:
      return BusState::bus_off;
    default:
      return BusState::active;
  }
}

void read_link_info(Bytes info, Interface& interface) {
  Bytes data;
  for_each_attribute(info, [&](int type, Bytes value) {
    if (type == IFLA_INFO_KIND) interface.kind = text_of(value);
    if (type == IFLA_INFO_DATA) data = value;
  });
  if (interface.kind != "can") return;
  for_each_attribute(data, [&](int type, Bytes value) {
    if (type == IFLA_CAN_STATE) interface.bus_state = state_of(read_as<std::uint32_t>(value));
  });
}

[[noreturn]] void fail(const std::string& name, const char* what) {
  throw InterfaceError("interface " + name + ": " + what + ": " + std::strerror(errno));
}

std::vector<std::byte> ask_for_link(const std::string& name) {
  struct {
    nlmsghdr header{};
    ifinfomsg message{};
    rtattr attribute{};
    std::array<char, IFNAMSIZ> name{};
  } request;
  request.header.nlmsg_len = sizeof request;
  request.header.nlmsg_type = RTM_GETLINK;
  request.header.nlmsg_flags = NLM_F_REQUEST;
  request.attribute.rta_len = sizeof request.attribute + sizeof request.name;
  request.attribute.rta_type = IFLA_IFNAME;
  name.copy(request.name.data(), request.name.size() - 1);

  const int netlink = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  if (netlink < 0) fail(name, "cannot ask the kernel");
  std::vector<std::byte> reply(32768);
  ssize_t received = ::send(netlink, &request, sizeof request, 0);
  if (received >= 0) received = ::recv(netlink, reply.data(), reply.size(), 0);
  const int error = errno;
  ::close(netlink);
  errno = error;
  if (received < 0) fail(name, "cannot ask the kernel");
  reply.resize(static_cast<std::size_t>(received));
  return reply;
}

}  // namespace

std::optional<Interface> query_interface(const std::string& name) {
  if (name.empty() || name.size() >= IFNAMSIZ) return std::nullopt;
  const std::vector<std::byte> reply = ask_for_link(name);
  constexpr std::size_t message_at = aligned(sizeof(nlmsghdr));
  constexpr std::size_t attributes_at = message_at + aligned(sizeof(ifinfomsg));
  if (reply.size() < attributes_at || read_as<nlmsghdr>(reply).nlmsg_type != RTM_NEWLINK) return std::nullopt;

  const auto message = read_as<ifinfomsg>(Bytes(reply).subspan(message_at));
  Interface interface;
  interface.index = message.ifi_index;
  interface.up = (message.ifi_flags & IFF_UP) != 0;
  interface.is_can = message.ifi_type == ARPHRD_CAN;
  for_each_attribute(Bytes(reply).subspan(attributes_at), [&](int type, Bytes value) {
    if (type == IFLA_LINKINFO) read_link_info(value, interface);
  });
  return interface;
}

namespace {

/// Throws InterfaceError where it is absent or not a CAN interface.
Interface require_interface(const std::string& name) {
  const auto interface = query_interface(name);
  if (interface && interface->is_can) return *interface;
  if (interface) throw InterfaceError("interface " + name + " is not a CAN interface");
  throw InterfaceError("interface " + name + " does not exist; " +
                       (name.starts_with("vcan") ? "create it with: ip link add dev " + name +
                                                       " type vcan && ip link set " + name + " up"
                                                 : "list those that do with: ip -brief link show type can"));
}

}  // namespace

Interface require_can_interface(const std::string& name) {
  Interface interface = require_interface(name);
  if (!interface.up) {
    const bool real = interface.kind == "can" || (interface.kind.empty() && !name.starts_with("vcan"));
    throw InterfaceError("interface " + name + " is down; bring it up with: ip link set " + name + " up" +
                         (real ? " type can bitrate 1000000" : ""));
  }
  return interface;
}

bool is_virtual_interface(const std::string& name) {
  const Interface interface = require_interface(name);
  return interface.kind == "vcan" || interface.kind == "vxcan";
}

}  // namespace hystcan::can
