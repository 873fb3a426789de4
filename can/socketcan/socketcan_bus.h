// SocketCAN on Boost.Asio: a real interface, in real time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "can/bus.h"

namespace boost::asio {
class io_context;
}

namespace hystcan::can {

/// The interface can't be used: absent, down, not a CAN device, no permission. what() names it and the cure.
class InterfaceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Filters are set before bind; error frames are on, become state and counters, and don't reach the frame
/// handler; send() never blocks, and what the kernel refuses (ENOBUFS, EAGAIN, ENETDOWN) is dropped and
/// counted: the next cycle has a newer command. Where the interface goes down or vanishes the state is `down`
/// until one of its name is up, which is looked for every 50 ms; filters are set again. In bus-off the driver
/// is asked for its state every 50 ms, for the error frame that tells of the restart may be lost; until then
/// nothing is sent, for the kernel would keep it and let it out, stale, after the restart. Own frames
/// reach the host's other sockets and not this one. Arrival times are the kernel's stamps.
class SocketCanBus final : public Bus {
 public:
  /// Throws InterfaceError.
  SocketCanBus(boost::asio::io_context& context, const std::string& interface,
               std::span<const Filter> filters);
  ~SocketCanBus() override;

  bool send(const Frame& frame) override;
  void on_frame(FrameHandler handler) override;
  void on_state(StateHandler handler) override;
  BusState state() const override;
  std::optional<ErrorCounters> error_counters() const override;
  const BusCounters& counters() const override;

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the operations under way
};

/// True where the interface is a virtual one (vcan, vxcan): nothing real hangs on it. Throws InterfaceError
/// where absent.
bool is_virtual_interface(const std::string& interface);

/// The scheduler of an io_context: steady clock, absolute deadlines.
class AsioScheduler final : public Scheduler {
 public:
  explicit AsioScheduler(boost::asio::io_context& context) : context_(context) {}
  Time now() const override;
  std::unique_ptr<Timer> make_timer(std::function<void()> on_expiry) override;

 private:
  boost::asio::io_context& context_;
};

}  // namespace hystcan::can
