#include "can/socketcan/interface.h"

// net/if.h must be the first include: linux/if.h then leaves out the declarations that are also in net/if.h.
#include <net/if.h>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/can/raw.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "base/input_file.h"
#include "can/socketcan/socketcan_bus.h"

namespace hystcan::can {
namespace {

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

  const Descriptor netlink(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
  std::vector<std::byte> reply(32768);
  ssize_t received = netlink.get() < 0 ? -1 : ::send(netlink.get(), &request, sizeof request, 0);
  if (received >= 0) received = ::recv(netlink.get(), reply.data(), reply.size(), 0);
  if (received < 0) fail_at_interface(name, "cannot query the kernel");
  reply.resize(static_cast<std::size_t>(received));
  return reply;
}

/// Throws RunError if the kernel has no CAN support. Without this check, the error message would be about
/// a missing interface.
void require_can_support() {
  const Descriptor socket(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  if (socket.get() < 0 && (errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT))
    throw RunError(std::string("this kernel has no CAN support (AF_CAN: ") + std::strerror(errno) + ")",
                   {.remedy = "scripts/guest starts a kernel with CAN support"});
}

/// Returns the interface of this name. Throws RunError if it does not exist or is not a CAN interface.
Interface require_interface(const std::string& name) {
  require_can_support();
  const auto interface = query_interface(name);
  if (interface && interface->is_can) return *interface;
  if (interface) throw RunError("interface " + name + " is not a CAN interface");
  throw RunError(
      "interface " + name + " does not exist",
      {.remedy = name.starts_with("vcan")
                     ? "create it with: ip link add dev " + name + " type vcan && ip link set " + name + " up"
                     : "list the existing interfaces with: ip -brief link show type can"});
}

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

static_assert(CAN_STATE_BUS_OFF == static_cast<int>(BusState::bus_off), "Linux numbers the states as we do");

/// Converts the state that Linux reports. Returns nullopt if the CAN controller is stopped or sleeping,
/// because the interface is down.
std::optional<BusState> state_of(std::uint32_t can_state) {
  return can_state <= CAN_STATE_BUS_OFF ? std::optional(static_cast<BusState>(can_state)) : std::nullopt;
}

void read_control_mode(std::uint32_t flags, Interface& interface) {
  interface.listen_only = (flags & CAN_CTRLMODE_LISTENONLY) != 0;
  interface.loopback = (flags & CAN_CTRLMODE_LOOPBACK) != 0;
  interface.one_shot = (flags & CAN_CTRLMODE_ONE_SHOT) != 0;
}

void read_can_attribute(int type, Bytes value, Interface& interface) {
  if (type == IFLA_CAN_STATE) interface.bus_state = state_of(read_as<std::uint32_t>(value));
  if (type == IFLA_CAN_RESTART_MS) interface.restart_ms = read_as<std::uint32_t>(value);
  if (type == IFLA_CAN_CTRLMODE) read_control_mode(read_as<can_ctrlmode>(value).flags, interface);
  if (type == IFLA_CAN_BERR_COUNTER) {
    const auto counters = read_as<can_berr_counter>(value);
    interface.error_counters = ErrorCounters{.transmit = counters.txerr, .receive = counters.rxerr};
  }
  if (type != IFLA_CAN_BITTIMING && type != IFLA_CAN_DATA_BITTIMING) return;
  const auto timing = read_as<can_bittiming>(value);
  if (timing.bitrate == 0) return;  // the bit rate is not configured
  if (type == IFLA_CAN_DATA_BITTIMING) {
    interface.data_bitrate_bit_per_s = timing.bitrate;
    return;
  }
  interface.bitrate_bit_per_s = timing.bitrate;
  interface.sample_point = timing.sample_point / 1000.0;
}

/// Reads the kind of an interface (IFLA_INFO_KIND) and its data (IFLA_INFO_DATA). The kind decides the
/// meaning of the data, but may be after the data in the message.
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
  if (!statistics.empty()) interface.bus_offs = read_as<can_device_stats>(statistics).bus_off;
}

}  // namespace

void fail_at_interface(const std::string& name, const char* what) {
  throw RunError("interface " + name, std::string(what) + ": " + std::strerror(errno));
}

std::optional<Interface> query_interface(const std::string& name) {
  if (name.empty() || name.size() >= IFNAMSIZ) return std::nullopt;
  return parse_link_message(ask_for_link(name));
}

Interface require_can_interface(const std::string& name) {
  Interface interface = require_interface(name);
  if (!interface.up) {
    const bool real = interface.kind == "can" || (interface.kind.empty() && !name.starts_with("vcan"));
    throw RunError("interface " + name + " is down",
                   {.remedy = "bring it up with: ip link set " + name + " up" +
                              (real ? " type can bitrate 1000000" : "")});
  }
  return interface;
}

bool is_virtual_interface(const std::string& name) {
  const Interface interface = require_interface(name);
  return interface.kind == "vcan" || interface.kind == "vxcan";
}

void require_able_to_send(const std::string& name, const Interface& interface) {
  if (!interface.listen_only) return;
  throw RunError("interface " + name + " is listen-only",
                 {.remedy = "take it down and set: ip link set " + name + " type can listen-only off"});
}

void require_bit_rate(const std::string& name, const Interface& interface, const BitRates& rates) {
  constexpr double rounding = 0.01;  // tolerance: an adapter may not produce the exact bit rate
  if (!interface.bitrate_bit_per_s) return;
  const double off = static_cast<double>(*interface.bitrate_bit_per_s) / rates.nominal_bit_per_s - 1.0;
  if (std::abs(off) <= rounding) return;
  throw RunError(
      fmt::format("interface {} has a bit rate of {} bit/s", name, *interface.bitrate_bit_per_s),
      {.expected = fmt::format("{} bit/s", rates.nominal_bit_per_s),
       .remedy = fmt::format(
           "take it down and set: ip link set {} type can bitrate {}, or correct bitrate_bit_per_s", name,
           rates.nominal_bit_per_s)});
}

void require_able_to_carry_fd(const std::string& name, const Interface& interface,
                              const std::vector<std::string>& messages, const BitRates& rates) {
  if (messages.empty()) return;
  const std::uint32_t wanted = rates.data_bit_per_s;
  const auto refuse = [&](const std::string& found, const std::string& expected) {
    const std::string settings =
        interface.bitrate_bit_per_s
            ? fmt::format("type can bitrate {} dbitrate {} fd on", *interface.bitrate_bit_per_s,
                          wanted != 0 ? wanted : 4 * std::uint64_t{*interface.bitrate_bit_per_s})
            : "mtu 72";
    throw RunError(fmt::format("interface {} {}", name, found),
                   {.expected = fmt::format("{} for {}", expected, fmt::join(messages, ", ")),
                    .remedy = fmt::format("take it down and set: ip link set {} {}", name, settings)});
  };
  if (!interface.fd) refuse("does not accept CAN FD frames", "CAN FD");
  if (!interface.bitrate_bit_per_s || wanted == 0 || interface.data_bitrate_bit_per_s == wanted) return;
  refuse(interface.data_bitrate_bit_per_s
             ? fmt::format("has a data bit rate of {} bit/s", *interface.data_bitrate_bit_per_s)
             : "has no data bit rate",
         fmt::format("{} bit/s", wanted));
}

Refusal refusal_of(const Interface& now, const Interface& before) {
  if (now.listen_only && !before.listen_only) return Refusal::listen_only;
  if (now.bitrate_bit_per_s != before.bitrate_bit_per_s) return Refusal::other_bit_rate;
  if (before.fd && !now.fd) return Refusal::no_fd;
  return now.data_bitrate_bit_per_s != before.data_bitrate_bit_per_s ? Refusal::other_bit_rate
                                                                     : Refusal::none;
}

std::string describe(const std::string& name, const Interface& interface) {
  std::string text = name + ": ";
  if (interface.bitrate_bit_per_s)
    text += fmt::format("{:g} kbit/s, sample point {:g} %, ", *interface.bitrate_bit_per_s / 1000.0,
                        100.0 * interface.sample_point.value_or(0.0));
  else
    text += fmt::format("{}, no bit rate, ", interface.kind.empty() ? "CAN" : interface.kind);
  if (interface.restart_ms) text += fmt::format("restart-ms {}, ", *interface.restart_ms);
  if (interface.one_shot) text += "one-shot, ";
  if (interface.loopback) text += "loopback, ";
  if (interface.listen_only) text += "listen-only, ";
  if (interface.fd)
    text += interface.data_bitrate_bit_per_s ? fmt::format("FD with {:g} kbit/s in the data phase, ",
                                                           *interface.data_bitrate_bit_per_s / 1000.0)
                                             : "FD, ";
  if (interface.bus_state && *interface.bus_state != BusState::active)
    text += fmt::format("{}, ", to_string(*interface.bus_state));
  return text + fmt::format("qdisc {}, {} frames",
                            interface.queue_discipline.empty() ? "none" : interface.queue_discipline,
                            interface.transmit_queue_frames);
}

std::vector<std::string> find_warnings(const std::string& name, const Interface& interface) {
  std::vector<std::string> warnings;
  if (interface.restart_ms == 0U)
    warnings.push_back(fmt::format(
        "{} has restart-ms 0: bus-off lasts until a user runs ip link set {} type can restart", name, name));
  if (interface.loopback)
    warnings.push_back(fmt::format("{} is in loopback mode: nothing reaches the wire", name));
  if (interface.one_shot)
    warnings.push_back(fmt::format("{} is in one-shot mode: a frame that loses arbitration is lost", name));
  return warnings;
}

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
