#include "can/socketcan/asio_scheduler.h"

#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/io_context.hpp>
#include <optional>
#include <utility>

#include "can/socketcan/cancel_timer.h"

namespace hystcan::can {
namespace {

namespace asio = boost::asio;
using SteadyTimer =
    asio::basic_waitable_timer<std::chrono::steady_clock, asio::wait_traits<std::chrono::steady_clock>,
                               asio::io_context::executor_type>;

/// At most one wait is pending. A later deadline takes effect only when the old wait expires, so that
/// resetting a watchdog a thousand times per second needs no system call.
class Alarm : public std::enable_shared_from_this<Alarm> {
 public:
  Alarm(asio::io_context& context, std::function<void()> on_expiry)
      : timer_(context), on_expiry_(std::move(on_expiry)) {}

  void expire_at(Time deadline) {
    deadline_ = deadline;
    if (!waiting_until_ || deadline < *waiting_until_) wait();
  }

  void cancel() {
    deadline_.reset();
    waiting_until_.reset();
    ++generation_;
    cancel_timer(timer_);
  }

 private:
  void wait() {
    waiting_until_ = deadline_;
    timer_.expires_at(*deadline_);
    timer_.async_wait([self = shared_from_this(), generation = ++generation_](boost::system::error_code) {
      if (generation == self->generation_) self->expired();
    });
  }

  void expired() {
    waiting_until_.reset();
    if (std::chrono::steady_clock::now() < *deadline_) {
      wait();
      return;
    }
    deadline_.reset();
    on_expiry_();
  }

  SteadyTimer timer_;
  std::function<void()> on_expiry_;
  std::optional<Time> deadline_;
  std::optional<Time> waiting_until_;
  unsigned generation_ = 0;
};

class AsioTimer final : public Timer {
 public:
  AsioTimer(asio::io_context& context, std::function<void()> on_expiry)
      : alarm_(std::make_shared<Alarm>(context, std::move(on_expiry))) {}
  ~AsioTimer() override { alarm_->cancel(); }
  AsioTimer(const AsioTimer&) = delete;
  AsioTimer& operator=(const AsioTimer&) = delete;

  void expire_at(Time deadline) override { alarm_->expire_at(deadline); }
  void cancel() override { alarm_->cancel(); }

 private:
  std::shared_ptr<Alarm> alarm_;  ///< shared with the pending wait
};

}  // namespace

Time AsioScheduler::now() const { return std::chrono::steady_clock::now(); }

std::unique_ptr<Timer> AsioScheduler::make_timer(std::function<void()> on_expiry) {
  return std::make_unique<AsioTimer>(context_, std::move(on_expiry));
}

}  // namespace hystcan::can
