// A Bus (can/bus.h) on a real SocketCAN interface, with Boost.Asio.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "base/error.h"
#include "can/bus.h"

namespace boost::asio {
class io_context;
}

namespace hystcan::can {

/// A Bus on a SocketCAN interface.
///
/// - The bus sets its filters before bind. Error frames are enabled; they change state and counters and do
///   not reach the frame handler.
/// - send() never blocks. A frame that the kernel refuses (ENOBUFS, EAGAIN, ENETDOWN) is dropped and counted,
///   because the next cycle has a newer command.
/// - When the interface goes down or disappears, the state is `down`. Every 50 ms the bus searches for an
///   interface of this name that is up, and sets its filters again. It does not use an interface that is now
///   listen-only, has another bit rate, or does not accept CAN FD frames; refusal() returns the reason.
/// - In bus-off the bus queries the driver's state every 50 ms, because the error frame of the restart may
///   be lost. It sends nothing before the restart, because the kernel would store the frames and send them,
///   outdated, afterwards.
/// - The bus's own frames reach the other sockets of the host; the bus receives them only for on_sent().
/// - Arrival times are the kernel's time stamps.
class SocketCanBus final : public Bus {
 public:
  /// Throws RunError with the name and the remedy if the interface can't be used: it is absent, down or not a
  /// CAN device, or permission is missing.
  SocketCanBus(boost::asio::io_context& context, const std::string& interface,
               std::span<const Filter> filters);
  ~SocketCanBus() override;

  bool send(const Frame& frame) override;
  void on_frame(FrameHandler handler) override;
  bool on_sent(FrameHandler handler) override;
  void on_state(StateHandler handler) override;
  BusState state() const override;
  Refusal refusal() const override;
  std::optional<ErrorCounters> error_counters() const override;
  const BusCounters& counters() const override;

  /// Waits in the socket for one frame and passes it to the handler. This is faster than a wait in the
  /// io_context (docs/latency.md). From the first call on, the io_context no longer waits for frames. Returns
  /// false at the deadline, after a signal, or immediately if the interface is down. The caller must then run
  /// the io_context, so that it handles signals and other events. At the deadline, the function first passes
  /// all frames that have arrived. Otherwise a program that is late would report these frames as missing.
  bool receive_before(Time deadline);

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the pending operations, which may outlive this object
};

class AsioScheduler;

/// Runs `context` until it is stopped. The thread waits in the socket of `bus`, which must be the only socket
/// of `context`, and not in `context`. Therefore the handlers of `context`, for signals and requests, run
/// only between two waits: a wait ends at each deadline of `scheduler`, and when a signal interrupts the
/// thread.
void run_in_socket(boost::asio::io_context& context, AsioScheduler& scheduler, SocketCanBus& bus);

/// Returns true if the interface is virtual (vcan, vxcan), without a real bus. Throws RunError if it is
/// absent.
bool is_virtual_interface(const std::string& interface);

}  // namespace hystcan::can
