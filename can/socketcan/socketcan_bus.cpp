#include "can/socketcan/socketcan_bus.h"

#include <algorithm>
#include <utility>

#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/basic_stream_descriptor.hpp>
#include <cerrno>

#include "base/input_file.h"
#include "can/log/error_frame.h"
#include "can/socketcan/asio_scheduler.h"
#include "can/socketcan/cancel_timer.h"
#include "can/socketcan/interface.h"
#include "can/socketcan/raw_socket.h"
#include "can/socketcan/socket_alarm.h"

namespace hystcan::can {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using Executor = asio::io_context::executor_type;
using SteadyTimer = asio::basic_waitable_timer<std::chrono::steady_clock,
                                               asio::wait_traits<std::chrono::steady_clock>, Executor>;

constexpr std::chrono::milliseconds retry_period{50};

bool interface_is_gone(int error) { return error == ENETDOWN || error == ENODEV || error == ENXIO; }

}  // namespace

class SocketCanBus::Impl : public std::enable_shared_from_this<Impl> {
 public:
  Impl(asio::io_context& context, std::string interface, std::span<const Filter> filters)
      : interface_(std::move(interface)),
        filters_(filters.begin(), filters.end()),
        watch_(context),
        retry_timer_(context),
        restart_timer_(context) {
    if (const auto found = query_interface(interface_)) at_start_ = *found;
    open();
  }

  void start() {
    if (state_ == BusState::bus_off) ask_later_whether_restarted();
    wait();
  }

  bool send(const Frame& frame) {
    const int error = try_to_send(frame);
    if (error == 0) {
      ++counters_.sent;
      return true;
    }
    ++counters_.send_refused;
    if (is_open() && interface_is_gone(error) && !retrying_) retry_after(Duration::zero());
    return false;
  }

  void close() {
    closed_ = true;
    cancel_timer(retry_timer_);
    cancel_timer(restart_timer_);
    close_socket();
  }

  bool receive_before(Time deadline) {
    if (watch_.is_open()) leave_context();
    if (!is_open()) return false;
    if (std::exchange(alarm_at_, deadline) != deadline) alarm_->set(deadline);
    const int count = batch_.read(socket_->get(), 1);
    if (count == 1) take(0);
    const Time now = std::chrono::steady_clock::now();
    if (count == 1 && now < deadline) return true;
    alarm_at_.reset();
    if (count == 1)
      receive_queued(ReceiveBatch::capacity, now);
    else if (errno != EAGAIN && errno != EINTR)
      lose_interface();
    return false;
  }

  void tell_sent(FrameHandler handler) {
    on_sent_ = std::move(handler);
    if (is_open()) receive_own_frames(socket_->get());
  }

  FrameHandler on_frame;
  StateHandler on_state;

  BusState state() const { return state_; }
  Refusal refusal() const { return refusal_; }
  std::optional<ErrorCounters> error_counters() const { return error_counters_; }
  const BusCounters& counters() const { return counters_; }

 private:
  /// Sends a frame. Returns 0 or an errno. In bus-off, returns ENOBUFS: the kernel would store the frame and
  /// send it after the restart.
  int try_to_send(const Frame& frame) {
    if (!is_open()) return ENETDOWN;
    if (state_ == BusState::bus_off) return ENOBUFS;
    return write_frame(socket_->get(), frame);
  }

  void open() {
    Descriptor socket(open_raw_socket(interface_, filters_));
    if (on_sent_) receive_own_frames(socket.get());
    const auto found = query_interface(interface_);
    watch_.assign(socket.get());
    socket_.emplace(std::move(socket));
    batch_.restart();
    state_when_up_ = found ? found->bus_state.value_or(BusState::active) : BusState::active;
    error_counters_ = found ? found->error_counters : std::nullopt;
    if (state_ != BusState::down) state_ = state_when_up_;
  }

  bool is_open() const { return socket_.has_value(); }

  /// Closes the socket, after the alarm and the context have released it: they must not act on a later file
  /// with the same descriptor.
  void close_socket() {
    alarm_.reset();
    alarm_at_.reset();
    if (watch_.is_open()) watch_.release();
    socket_.reset();
  }

  void leave_context() {
    alarm_.emplace(socket_->get());
    watch_.release();
  }

  void wait() {
    watch_.async_wait(asio::posix::descriptor_base::wait_read, [self = shared_from_this()](error_code error) {
      if (!error && !self->closed_) self->receive();
    });
  }

  /// Reads the first frame alone and passes it to the handler. The answer that the handler sends then does
  /// not wait for the reading of other frames, or for a read of an empty queue.
  void receive() {
    receive_queued(1, Time::max());
    if (is_open()) wait();
  }

  /// Reads frames in batches: at most `room` frames in the first batch, at most ReceiveBatch::capacity in
  /// each further batch. Stops when the queue is empty, or when a batch ends with a frame that arrived after
  /// `last_arrival`.
  void receive_queued(std::size_t room, Time last_arrival) {
    for (Time arrival{}; is_open() && arrival <= last_arrival; room = ReceiveBatch::capacity) {
      const int count = batch_.read(socket_->get(), room);
      if (count < 0 && errno != EAGAIN && errno != EINTR) lose_interface();
      if (count > 0) arrival = batch_.received(static_cast<std::size_t>(count) - 1);
      for (int i = 0; i < count && is_open(); ++i) take(static_cast<std::size_t>(i));
      if (count < static_cast<int>(room)) break;
    }
  }

  void take(std::size_t index) {
    Frame frame = batch_.frame(index);
    frame.fd_flags &= fd_bit_rate_switch | fd_error_state;  // Linux 5.18 and later add a flag "FD"
    const Time received = batch_.received(index);
    if (batch_.is_own(index)) {
      if (on_sent_) on_sent_(frame, received);
      return;
    }
    counters_.receive_lost = lost_before_ + batch_.lost();
    // The kernel passes every remote frame (raw_socket.cpp). Drop a remote frame that no filter passes.
    if (frame.kind == FrameKind::remote &&
        std::ranges::find(filters_, frame.id, &Filter::id) == filters_.end())
      return;
    if (frame.kind == FrameKind::error) {
      take_error(interpret(frame));
      return;
    }
    ++counters_.received;
    if (on_frame) on_frame(frame, received);
  }

  void take_error(const ErrorReport& report) {
    count(report, counters_);
    if (report.error_counters) error_counters_ = report.error_counters;
    if (report.state) enter(*report.state);
  }

  void lose_interface() {
    lost_before_ = counters_.receive_lost;
    close_socket();
    retry_after(retry_period);
    enter(BusState::down);
  }

  void retry_after(Duration delay) {
    retrying_ = true;
    retry_timer_.expires_after(delay);
    retry_timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error && !self->closed_) self->retry();
    });
  }

  void retry() {
    retrying_ = false;
    if (is_open()) {  // send() found the interface lost, and left the socket open
      lose_interface();
      return;
    }
    try {
      const auto found = query_interface(interface_);
      refusal_ = found && found->up ? refusal_of(*found, at_start_) : Refusal::none;
      if (refusal_ != Refusal::none) return retry_after(retry_period);
      open();
    } catch (const RunError&) {
      retry_after(retry_period);
      return;
    }
    wait();
    enter(state_when_up_);
  }

  void enter(BusState state) {
    if (std::exchange(state_, state) == state) return;
    counters_.count_entry(state);
    if (state == BusState::bus_off) ask_later_whether_restarted();
    if (on_state) on_state(state);
  }

  void ask_later_whether_restarted() {
    restart_timer_.expires_after(retry_period);
    restart_timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error && !self->closed_ && self->state_ == BusState::bus_off) self->ask_whether_restarted();
    });
  }

  /// Queries the state of the CAN controller. A virtual interface reports no state: only an error frame, or
  /// taking the interface down, ends its bus-off.
  void ask_whether_restarted() {
    const auto found = query_interface(interface_);
    if (found && found->up && found->bus_state && *found->bus_state != BusState::bus_off) {
      enter(*found->bus_state);
    } else {
      ask_later_whether_restarted();
    }
  }

  FrameHandler on_sent_;
  std::string interface_;
  std::vector<Filter> filters_;
  std::optional<Descriptor> socket_;                      ///< nullopt while the interface is down
  asio::posix::basic_stream_descriptor<Executor> watch_;  ///< socket_, while the io_context waits for frames
  std::optional<SocketAlarm> alarm_;                      ///< ends the wait in receive_before()
  std::optional<Time> alarm_at_;
  SteadyTimer retry_timer_;    ///< time of the next search for the interface after it was lost
  SteadyTimer restart_timer_;  ///< in bus-off, time of the next query of the controller's state
  ReceiveBatch batch_;
  Interface at_start_;
  Refusal refusal_ = Refusal::none;
  BusState state_ = BusState::active;
  BusState state_when_up_ = BusState::active;
  std::optional<ErrorCounters> error_counters_;
  BusCounters counters_;
  std::uint64_t lost_before_ = 0;  ///< frames lost on earlier sockets
  bool retrying_ = false;
  bool closed_ = false;
};

SocketCanBus::SocketCanBus(asio::io_context& context, const std::string& interface,
                           std::span<const Filter> filters)
    : impl_(std::make_shared<Impl>(context, interface, filters)) {
  impl_->start();
}

SocketCanBus::~SocketCanBus() { impl_->close(); }

bool SocketCanBus::receive_before(Time deadline) { return impl_->receive_before(deadline); }
bool SocketCanBus::send(const Frame& frame) { return impl_->send(frame); }
void SocketCanBus::on_frame(FrameHandler handler) { impl_->on_frame = std::move(handler); }
bool SocketCanBus::on_sent(FrameHandler handler) {
  impl_->tell_sent(std::move(handler));
  return true;
}
void SocketCanBus::on_state(StateHandler handler) { impl_->on_state = std::move(handler); }
BusState SocketCanBus::state() const { return impl_->state(); }
Refusal SocketCanBus::refusal() const { return impl_->refusal(); }
std::optional<ErrorCounters> SocketCanBus::error_counters() const { return impl_->error_counters(); }
const BusCounters& SocketCanBus::counters() const { return impl_->counters(); }

void run_in_socket(asio::io_context& context, AsioScheduler& scheduler, SocketCanBus& bus) {
  const auto work = asio::make_work_guard(context);  // the context stops itself if it has nothing to wait for
  while (!context.stopped()) {
    while (!context.stopped() && bus.receive_before(scheduler.next_deadline())) continue;
    const bool is_down = bus.state() == BusState::down;
    scheduler.wait_in_context(is_down);
    scheduler.run_expired();
    if (is_down)
      context.run_one();
    else
      context.poll();
  }
}

}  // namespace hystcan::can
