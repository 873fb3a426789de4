// The class that all code uses for access to a CAN bus. Its two implementations are SocketCAN and the
// simulated bus.
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

/// The states of CAN fault confinement (ISO 11898-1), and `down`: the network interface is missing or
/// switched off.
enum class BusState : std::uint8_t { active, warning, passive, bus_off, down };

constexpr std::string_view to_string(BusState state) {
  return std::to_array<std::string_view>(
      {"active", "warning", "passive", "bus-off", "down"})[static_cast<std::size_t>(state)];
}

/// Why the program does not use an interface that was down and is up again: this property of the interface is
/// different from its value at the start of the program.
enum class Refusal : std::uint8_t { none, listen_only, other_bit_rate, no_fd };

constexpr std::string_view to_string(Refusal refusal) {
  return std::to_array<std::string_view>(
      {"none", "the interface is listen-only now", "the bit rate of the interface has changed",
       "the interface does not accept CAN FD frames now"})[static_cast<std::size_t>(refusal)];
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
  std::uint64_t send_refused = 0;  ///< frames not sent: queue full (ENOBUFS, EAGAIN) or interface down
  std::uint64_t receive_lost = 0;  ///< received frames that the kernel dropped before the program read them
                                   ///< (SO_RXQ_OVFL)
  std::uint64_t error_frames = 0;  ///< error frames from the CAN controller; the counters below count their
                                   ///< causes
  std::uint64_t warnings = 0;      ///< number of changes to the state error-warning
  std::uint64_t passives = 0;      ///< number of changes to the state error-passive
  std::uint64_t bus_offs = 0;      ///< number of changes to the state bus-off
  std::uint64_t restarts = 0;      ///< number of restarts after bus-off
  std::uint64_t not_acknowledged = 0;
  std::uint64_t arbitration_lost = 0;
  std::uint64_t protocol_errors = 0;       ///< number of bit, stuff, form and CRC errors
  std::uint64_t controller_overflows = 0;  ///< number of times that a queue inside the CAN adapter was full
  std::uint64_t transceiver_errors = 0;

  /// Counts one change of the CAN controller to the state `state`. Call only if the state changed.
  void count_entry(BusState state) {
    if (state == BusState::warning) ++warnings;
    if (state == BusState::passive) ++passives;
    if (state == BusState::bus_off) ++bus_offs;
  }
};

/// A receive filter that passes the frames of one identifier. The filter does not check the frame type: it
/// also passes standard, extended, remote and FD frames with the same identifier, so that the integrity check
/// can count frames of a wrong type.
struct Filter {
  std::uint32_t id = 0;
  bool extended = false;  ///< true if the node expects a 29-bit identifier
};

/// The connection of one node to a bus. All calls and all handlers run on the thread of the scheduler.
class Bus {
 public:
  /// `received`: the time at which the frame was complete on the wire, by the clock of the Scheduler.
  using FrameHandler = std::function<void(const Frame& frame, Time received)>;
  using StateHandler = std::function<void(BusState state)>;

  virtual ~Bus() = default;

  /// Passes a frame to the bus without waiting for its transmission. Returns false if the bus dropped the
  /// frame: the frame is never sent, and counters().send_refused counts it.
  virtual bool send(const Frame& frame) = 0;
  virtual void on_frame(FrameHandler handler) = 0;
  /// Sets the handler for frames that this connection has sent. The bus calls the handler after the frame is
  /// complete on the wire; a virtual interface, which has no wire, calls it after the frame is queued. The
  /// bus may leave out sent frames that the filters of this connection do not pass. Returns false if the bus
  /// does not report sent frames.
  virtual bool on_sent(FrameHandler handler) = 0;
  virtual void on_state(StateHandler handler) = 0;
  virtual BusState state() const = 0;
  /// Returns why the program does not use the interface; always `none` unless the state is `down`.
  virtual Refusal refusal() const { return Refusal::none; }
  /// Returns the last error counters that the CAN controller reported; nullopt before its first report. A
  /// virtual interface never reports error counters.
  virtual std::optional<ErrorCounters> error_counters() const { return std::nullopt; }
  virtual const BusCounters& counters() const = 0;
};

/// A function that opens the connection of one node to the bus. The node receives all frames that the filters
/// pass, and perhaps others: it must check the identifier of each received frame.
using Attach = std::function<std::unique_ptr<Bus>(std::span<const Filter> filters)>;

// In Linux, the name of a network interface has 1 to 15 characters without spaces, '/' and ':'. The names "."
// and ".." are not allowed.

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
