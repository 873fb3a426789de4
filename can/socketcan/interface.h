// A network interface as the kernel describes it (rtnetlink).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can/bus.h"

namespace hystcan::can {

/// Since the driver was loaded, by whatever program.
struct DriverStatistics {
  std::uint32_t bus_errors = 0;
  std::uint32_t warnings = 0;
  std::uint32_t passives = 0;
  std::uint32_t bus_offs = 0;
  std::uint32_t arbitration_lost = 0;
  std::uint32_t restarts = 0;
};

/// What is optional is empty where the driver states none: a virtual interface has no bit rate.
struct Interface {
  int index = 0;
  bool up = false;
  bool is_can = false;
  std::string kind;                   ///< "vcan", "vxcan", "can"; empty where the driver states none
  std::optional<BusState> bus_state;  ///< of the controller
  std::optional<std::uint32_t> bitrate_bit_per_s;
  std::optional<double> sample_point;       ///< share of the bit time
  std::optional<std::uint32_t> restart_ms;  ///< from bus-off to restart; 0: never by itself
  bool listen_only = false;
  bool loopback = false;
  bool one_shot = false;
  bool fd = false;  ///< takes CAN FD frames: its MTU is one of them, 72 bytes, or more
  std::optional<ErrorCounters> error_counters;
  std::optional<DriverStatistics> driver_statistics;
  std::uint32_t transmit_queue_frames = 0;
  std::string queue_discipline;  ///< "pfifo_fast", "noqueue"
};

/// Empty where there is no interface of this name. Throws InterfaceError where the kernel can't be asked.
std::optional<Interface> query_interface(const std::string& name);

/// The interface, if it can carry CAN frames now. Throws InterfaceError, with the cure, where it can't.
Interface require_can_interface(const std::string& name);

/// Throws InterfaceError, with the cure, where the interface only listens.
void require_able_to_send(const std::string& name, const Interface& interface);

/// Throws InterfaceError, with the cure, where the interface takes no CAN FD frames and one of `messages`,
/// names of the DBC, must be one.
void require_able_to_carry_fd(const std::string& name, const Interface& interface,
                              const std::vector<std::string>& messages);

/// One line: `can0: 1000 kbit/s, sample point 75 %, restart-ms 100, qdisc pfifo_fast, 10 frames`.
std::string describe(const std::string& name, const Interface& interface);

/// What lets a node run but not as meant: another bit rate than the configured one, no restart after bus-off.
std::vector<std::string> find_doubts(const std::string& name, const Interface& interface,
                                     double bitrate_bit_per_s);

}  // namespace hystcan::can
