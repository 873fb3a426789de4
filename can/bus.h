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

/// Why an interface that was lost and is up again is not used: it differs from what it was at the start.
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

  /// The controller has entered this state from another.
  void count_entry(BusState state) {
    if (state == BusState::warning) ++warnings;
    if (state == BusState::passive) ++passives;
    if (state == BusState::bus_off) ++bus_offs;
  }
};

/// Receive exactly this identifier. The filter also passes an extended, remote or FD frame with the same
/// identifier, so that the integrity check can count it.
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

  /// Hands a frame to the bus and does not wait. False: the frame is dropped and counted, and is never sent.
  virtual bool send(const Frame& frame) = 0;
  virtual void on_frame(FrameHandler handler) = 0;
  /// `handler` gets the frames of this connection that have left (the echo): they were complete on the
  /// wire, or in the queue of a virtual interface, and a filter passes them. Returns false where the bus
  /// does not report that.
  virtual bool on_sent(FrameHandler handler) = 0;
  virtual void on_state(StateHandler handler) = 0;
  virtual BusState state() const = 0;
  /// Other than none only while the state is `down`.
  virtual Refusal refusal() const { return Refusal::none; }
  /// The counters that the bus reported last. Empty: it has reported none (a virtual interface never does).
  virtual std::optional<ErrorCounters> error_counters() const { return std::nullopt; }
  virtual const BusCounters& counters() const = 0;
};

/// Opens the connection of one node. It receives the frames of the filters; a simulated bus may deliver more.
using Attach = std::function<std::unique_ptr<Bus>(std::span<const Filter> filters)>;

// The rule that Linux has for the names of network interfaces.

inline constexpr std::string_view expected_interface_name =
    "the name of an interface: 1 to 15 characters without spaces, / and :";

/// True if an interface can have this name: `vcan0`.
constexpr bool is_interface_name(std::string_view name) {
  constexpr std::size_t longest = 15;  // IFNAMSIZ less the final zero
  const auto fits = [](char c) { return c != '/' && c != ':' && c != ' ' && !(c >= '\t' && c <= '\r'); };
  return !name.empty() && name.size() <= longest && name != "." && name != ".." &&
         std::ranges::all_of(name, fits);
}

}  // namespace hystcan::can
