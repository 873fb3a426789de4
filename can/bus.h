// The seam to the world: everything above it runs unchanged on SocketCAN and on the simulated bus.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "can/frame.h"
#include "can/scheduler.h"

namespace hystcan::can {

/// CAN fault confinement (ISO 11898-1), and `down` where the interface itself is gone or not up.
enum class BusState : std::uint8_t { active, warning, passive, bus_off, down };

std::string_view to_string(BusState state);

/// Transmit and receive error counter of the CAN controller (ISO 11898-1): warning from 96, passive from 128,
/// bus-off where the transmit counter passes 255.
struct ErrorCounters {
  std::uint16_t transmit = 0;
  std::uint16_t receive = 0;

  friend bool operator==(const ErrorCounters&, const ErrorCounters&) = default;
};

struct BusCounters {
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t send_refused = 0;  ///< queue full (ENOBUFS, EAGAIN) or interface down: the frame is dropped
  std::uint64_t receive_lost = 0;  ///< frames the kernel dropped before we read them (SO_RXQ_OVFL)
  std::uint64_t error_frames = 0;  ///< error frames from the controller; those below by what they tell
  std::uint64_t warnings = 0;      ///< changes to error-warning, passive, bus-off; restarts after it
  std::uint64_t passives = 0;
  std::uint64_t bus_offs = 0;
  std::uint64_t restarts = 0;
  std::uint64_t not_acknowledged = 0;
  std::uint64_t arbitration_lost = 0;
  std::uint64_t protocol_errors = 0;       ///< bit, stuff, form, CRC: the wire said something else
  std::uint64_t controller_overflows = 0;  ///< the adapter's own queues
  std::uint64_t transceiver_errors = 0;
};

/// Receive exactly this identifier, as a data frame or as what pretends to be one: extended, remote and FD
/// frames in its place are let through for the integrity check to count.
struct Filter {
  std::uint32_t id = 0;
  bool extended = false;
};

/// One node's connection to a bus. Single-threaded: all calls and handlers on the scheduler's thread.
class Bus {
 public:
  /// `received`: when the frame was complete on the wire, in the scheduler's time.
  using FrameHandler = std::function<void(const Frame& frame, Time received)>;
  using StateHandler = std::function<void(BusState state)>;

  virtual ~Bus() = default;

  /// Hands a frame to the bus without waiting. False: dropped and counted; nothing is queued to burst out
  /// later.
  virtual bool send(const Frame& frame) = 0;
  virtual void on_frame(FrameHandler handler) = 0;
  virtual void on_state(StateHandler handler) = 0;
  virtual BusState state() const = 0;
  /// As last told; empty where the bus has told none (a virtual interface never does).
  virtual std::optional<ErrorCounters> error_counters() const { return std::nullopt; }
  virtual const BusCounters& counters() const = 0;
};

/// Opens one node's own connection, which receives what the filters name (a simulated bus may deliver more).
using Attach = std::function<std::unique_ptr<Bus>(std::span<const Filter> filters)>;

}  // namespace hystcan::can
