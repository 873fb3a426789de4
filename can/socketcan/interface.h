// The properties of a network interface, as the kernel reports them (rtnetlink).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "can/bus.h"
#include "can/frame_bits.h"

namespace hystcan::can {

/// The properties of a network interface. An optional member is nullopt if the driver reports no value; for
/// example, a virtual interface has no bit rate.
struct Interface {
  int index = 0;
  bool up = false;
  bool is_can = false;
  std::string kind;                   ///< kind of driver: "vcan", "vxcan", "can"; empty if not reported
  std::optional<BusState> bus_state;  ///< state of the CAN controller
  std::optional<std::uint32_t> bitrate_bit_per_s;
  std::optional<std::uint32_t> data_bitrate_bit_per_s;  ///< bit rate of the CAN FD data phase
  std::optional<double> sample_point;                   ///< sample point as a fraction of the bit time
  std::optional<std::uint32_t> restart_ms;  ///< time from bus-off to restart; 0: no automatic restart
  bool listen_only = false;
  bool loopback = false;
  bool one_shot = false;
  bool fd = false;  ///< true if the interface accepts CAN FD frames: its MTU is at least 72 bytes
  std::optional<ErrorCounters> error_counters;
  std::optional<std::uint32_t> bus_offs;  ///< number of bus-offs since the driver was loaded
  std::uint32_t transmit_queue_frames = 0;
  std::string queue_discipline;  ///< name of the queue, such as "pfifo_fast" or "noqueue"
};

/// Throws RunError with the text "interface NAME: WHAT: " and the text of errno.
[[noreturn]] void fail_at_interface(const std::string& name, const char* what);

/// Requests the properties of an interface from the kernel. Returns nullopt if there is no interface of this
/// name. Throws RunError if the kernel does not answer.
std::optional<Interface> query_interface(const std::string& name);

/// Returns the properties of the interface if it is a CAN interface and up; otherwise throws RunError with
/// the remedy.
Interface require_can_interface(const std::string& name);

/// Throws RunError with the remedy if the interface is listen-only.
void require_able_to_send(const std::string& name, const Interface& interface);

/// Throws RunError with the remedy if the nominal bit rate of the interface differs from `rates`. A node with
/// a wrong bit rate disturbs every frame of the other nodes.
void require_bit_rate(const std::string& name, const Interface& interface, const BitRates& rates);

/// Checks that an interface can send CAN FD frames. `messages`: the names of the DBC messages that need CAN
/// FD; if there are none, the function checks nothing. Throws RunError with the remedy if the interface does
/// not accept CAN FD frames, or if its data bit rate differs from `rates`.
void require_able_to_carry_fd(const std::string& name, const Interface& interface,
                              const std::vector<std::string>& messages, const BitRates& rates);

/// Compares the properties of an interface with `before`, its properties at the start of the program. Returns
/// a change after which the program must not use the interface any more; `none` if there is no such change.
Refusal refusal_of(const Interface& now, const Interface& before);

/// Returns one line: `can0: 1000 kbit/s, sample point 75 %, restart-ms 100, qdisc pfifo_fast, 10 frames`.
std::string describe(const std::string& name, const Interface& interface);

/// Returns warnings about settings of the interface that are probably a mistake, although a node can run with
/// them. Example: no automatic restart after bus-off.
std::vector<std::string> find_warnings(const std::string& name, const Interface& interface);

/// Parses RTM_NEWLINK, the kernel's message about an interface (rtnetlink(7), linux/can/netlink.h). `message`
/// begins with the header nlmsghdr. Returns nullopt for any other type of message, such as the error message
/// for a missing interface. The parser skips attributes that are truncated or unknown.
std::optional<Interface> parse_link_message(std::span<const std::byte> message);

}  // namespace hystcan::can
