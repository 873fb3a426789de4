// The interface to a CAN bus. All code above it runs unchanged on SocketCAN and on the simulated bus.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "can/frame.h"
#include "can/scheduler.h"

namespace hystcan::can {

/// The states of CAN fault confinement (ISO 11898-1), and `down`: the interface is absent or not up.
enum class BusState : std::uint8_t { active, warning, passive, bus_off, down };

constexpr std::string_view to_string(BusState state) {
  return std::to_array<std::string_view>(
      {"active", "warning", "passive", "bus-off", "down"})[static_cast<std::size_t>(state)];
}

/// Why the bus does not use an interface that was down and is up again: a property changed since the start.
enum class Refusal : std::uint8_t { none, listen_only, other_bit_rate, no_fd };

constexpr std::string_view to_string(Refusal refusal) {
  return std::to_array<std::string_view>(
      {"none", "it is listen-only now", "it has another bit rate now",
       "it takes no CAN FD frames now"})[static_cast<std::size_t>(refusal)];
}

/// Transmit and receive error counter of the CAN controller (ISO 11898-1).
///
///   warning   either counter >= 96
///   passive   either counter >= 128
///   bus-off   transmit counter > 255
struct ErrorCounters {
  std::uint16_t transmit = 0;
  std::uint16_t receive = 0;

  friend bool operator==(const ErrorCounters&, const ErrorCounters&) = default;
};

struct BusCounters {
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t send_refused = 0;  ///< queue full (ENOBUFS, EAGAIN) or interface down: the frame is dropped
  std::uint64_t receive_lost = 0;  ///< the kernel dropped the frame before the program read it (SO_RXQ_OVFL)
  std::uint64_t error_frames = 0;  ///< error frames from the controller; the counters below give the causes
  std::uint64_t warnings = 0;      ///< changes to error-warning
  std::uint64_t passives = 0;      ///< changes to error-passive
  std::uint64_t bus_offs = 0;      ///< changes to bus-off
  std::uint64_t restarts = 0;      ///< restarts after bus-off
  std::uint64_t not_acknowledged = 0;
  std::uint64_t arbitration_lost = 0;
  std::uint64_t protocol_errors = 0;       ///< bit, stuff, form and CRC errors
  std::uint64_t controller_overflows = 0;  ///< a queue inside the adapter was full
  std::uint64_t transceiver_errors = 0;

  /// Counts the entry of the controller into `state`. The caller calls it only if the state changed.
  void count_entry(BusState state) {
    if (state == BusState::warning) ++warnings;
    if (state == BusState::passive) ++passives;
    if (state == BusState::bus_off) ++bus_offs;
  }
};

/// A receive filter for exactly this identifier. The filter also passes extended, remote and FD frames with
/// the same identifier, so that the integrity check can count them.
struct Filter {
  std::uint32_t id = 0;
  bool extended = false;
};

/// The connection of one node to a bus. All calls and all handlers run on the thread of the scheduler.
class Bus {
 public:
  /// `received` is the time at which the frame was complete on the wire, in the time of the scheduler.
  using FrameHandler = std::function<void(const Frame& frame, Time received)>;
  using StateHandler = std::function<void(BusState state)>;

  virtual ~Bus() = default;

  /// Passes a frame to the bus without waiting. Returns false if the bus dropped the frame; the drop is
  /// counted and the frame is never sent.
  virtual bool send(const Frame& frame) = 0;
  virtual void on_frame(FrameHandler handler) = 0;
  /// `handler` receives the echo of each frame that this connection sent and that its filters pass. The echo
  /// arrives after the frame is complete on the wire, or in the queue of a virtual interface. Returns false
  /// if the bus does not report sent frames.
  virtual bool on_sent(FrameHandler handler) = 0;
  virtual void on_state(StateHandler handler) = 0;
  virtual BusState state() const = 0;
  /// Returns why the bus does not use the interface; always `none` unless the state is `down`.
  virtual Refusal refusal() const { return Refusal::none; }
  /// The last counters that the bus reported; nullopt if it reported none (a virtual interface never does).
  virtual std::optional<ErrorCounters> error_counters() const { return std::nullopt; }
  virtual const BusCounters& counters() const = 0;
};

/// Opens the connection of one node. The node receives the frames that the filters pass; a simulated bus may
/// deliver more.
using Attach = std::function<std::unique_ptr<Bus>(std::span<const Filter> filters)>;

// The Linux rule for the names of network interfaces.

inline constexpr std::string_view expected_interface_name =
    "the name of an interface: 1 to 15 characters without spaces, / and :";

/// Returns true if an interface can have this name (example: `vcan0`).
constexpr bool is_interface_name(std::string_view name) {
  constexpr std::size_t longest = 15;  // IFNAMSIZ without the terminating zero
  const auto fits = [](char c) { return c != '/' && c != ':' && c != ' ' && !(c >= '\t' && c <= '\r'); };
  return !name.empty() && name.size() <= longest && name != "." && name != ".." &&
         std::ranges::all_of(name, fits);
}

}  // namespace hystcan::can
