// The event loop of a process on a real bus. A signal ends it cleanly.
#pragma once

#include <sys/prctl.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "can/socketcan/asio_scheduler.h"
#include "can/socketcan/socketcan_bus.h"

namespace hystcan::app {

class LiveLoop {
 public:
  /// Disables huge pages. A kernel with init_on_alloc clears each huge page (2 MB) when any thread allocates
  /// it. On a slow core this takes several cycles. A kernel that is not preemptible blocks the control thread
  /// for that time.
  explicit LiveLoop(std::string interface) : interface_(std::move(interface)) {
    prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0);
  }

  can::Scheduler& scheduler() { return scheduler_; }
  /// Returns the context of this loop, for a control socket on the same thread.
  boost::asio::io_context& context() { return context_; }
  can::Attach attach() {
    return [this](std::span<const can::Filter> filters) -> std::unique_ptr<can::Bus> {
      return std::make_unique<can::SocketCanBus>(context_, interface_, filters);
    };
  }
  /// Returns a function that opens the bus of a controller. The controller must be the only node of this
  /// loop. run() then waits for frames in the socket of this bus (can::run_in_socket). The bus must exist
  /// until run() returns.
  can::Attach attach_controller() {
    return [this](std::span<const can::Filter> filters) -> std::unique_ptr<can::Bus> {
      auto bus = std::make_unique<can::SocketCanBus>(context_, interface_, filters);
      controller_bus_ = bus.get();
      return bus;
    };
  }

  /// Runs until stop(). Calls `on_signal` for SIGINT (Ctrl-C), SIGTERM, SIGQUIT (Ctrl-\\), SIGHUP and SIGXCPU
  /// (the processor time limit). Ignores other signals that would end or stop the process although it has no
  /// error: SIGUSR1, SIGUSR2, timers, input and output, the terminal access of a background job (SIGTTIN,
  /// SIGTTOU), the supply voltage (SIGPWR), SIGSTKFLT and real-time signals.
  void run(std::function<void(int signal)> on_signal) {
    on_signal_ = std::move(on_signal);
    for (const int signal : {SIGINT, SIGTERM, SIGQUIT, SIGHUP, SIGXCPU}) signals_.add(signal);
    for (const int signal :
         {SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGIO, SIGPWR, SIGSTKFLT, SIGTTIN, SIGTTOU})
      std::signal(signal, SIG_IGN);
    for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) std::signal(signal, SIG_IGN);
    await_signal();
    if (controller_bus_ == nullptr)
      context_.run();
    else
      can::run_in_socket(context_, scheduler_, *controller_bus_);
  }
  void stop() { context_.stop(); }

 private:
  void await_signal() {
    signals_.async_wait([this](const boost::system::error_code& error, int signal) {
      if (error) return;
      on_signal_(signal);
      await_signal();
    });
  }

  /// The context does not use locks, because only one thread uses it. For this reason the process must not
  /// have a second signal_set: Boost.Asio would pass a signal from the thread of that set to this context.
  boost::asio::io_context context_{BOOST_ASIO_CONCURRENCY_HINT_UNSAFE};
  boost::asio::signal_set signals_{context_};
  can::AsioScheduler scheduler_{context_};
  std::string interface_;
  can::SocketCanBus* controller_bus_ = nullptr;
  std::function<void(int signal)> on_signal_;
};

}  // namespace hystcan::app
