#include "can/socketcan/asio_scheduler.h"

#include <algorithm>
#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/io_context.hpp>
#include <utility>
#include <vector>

#include "can/socketcan/cancel_timer.h"

namespace hystcan::can {
namespace {

namespace asio = boost::asio;
using SteadyTimer =
    asio::basic_waitable_timer<std::chrono::steady_clock, asio::wait_traits<std::chrono::steady_clock>,
                               asio::io_context::executor_type>;

}  // namespace

/// At most one wait of the context is pending. If a deadline moves to a later time, the pending wait is not
/// changed: it expires early and is followed by a wait for the new deadline. Therefore no system call is
/// necessary if a watchdog is reset a thousand times per second.
class AsioScheduler::Impl : public std::enable_shared_from_this<Impl> {
 public:
  struct Alarm {
    std::function<void()> on_expiry;
    Time deadline = Time::max();
  };

  explicit Impl(asio::io_context& context) : timer_(context) {}

  std::shared_ptr<Alarm> add(std::function<void()> on_expiry) {
    return alarms_.emplace_back(std::make_shared<Alarm>(Alarm{.on_expiry = std::move(on_expiry)}));
  }

  void remove(const std::shared_ptr<Alarm>& alarm) {
    alarm->deadline = Time::max();
    std::erase(alarms_, alarm);
    end_needless_wait();
  }

  void set(Alarm& alarm, Time deadline) {
    alarm.deadline = deadline;
    if (in_context_ && deadline < waiting_until_) wait();
    end_needless_wait();
  }

  void wait_in_context(bool in_context) {
    if (std::exchange(in_context_, in_context) == in_context) return;
    if (in_context)
      wait();
    else
      end_wait();
  }

  Time next_deadline() const {
    Time next = Time::max();
    for (const auto& alarm : alarms_) next = std::min(next, alarm->deadline);
    return next;
  }

  void run_expired() {
    const Time now = std::chrono::steady_clock::now();
    while (const auto alarm = first_expired(now)) {
      alarm->deadline = Time::max();
      alarm->on_expiry();
    }
  }

 private:
  std::shared_ptr<Alarm> first_expired(Time now) const {
    const auto first =
        std::ranges::min_element(alarms_, {}, [](const auto& alarm) { return alarm->deadline; });
    return first != alarms_.end() && (*first)->deadline <= now ? *first : nullptr;
  }

  void wait() {
    waiting_until_ = next_deadline();
    if (waiting_until_ == Time::max()) return;
    timer_.expires_at(waiting_until_);
    timer_.async_wait([self = shared_from_this(), generation = ++generation_](boost::system::error_code) {
      if (generation == self->generation_) self->end_of_wait();
    });
  }

  void end_of_wait() {
    waiting_until_ = Time::max();
    run_expired();
    if (in_context_ && waiting_until_ == Time::max()) wait();
  }

  /// Ends the pending wait of the io_context if no timer is set. An io_context without other work can then
  /// return from run().
  void end_needless_wait() {
    if (waiting_until_ != Time::max() && next_deadline() == Time::max()) end_wait();
  }

  void end_wait() {
    waiting_until_ = Time::max();
    ++generation_;
    cancel_timer(timer_);
  }

  SteadyTimer timer_;
  std::vector<std::shared_ptr<Alarm>> alarms_;
  bool in_context_ = true;
  Time waiting_until_ = Time::max();
  unsigned generation_ = 0;
};

class AsioScheduler::AsioTimer final : public Timer {
 public:
  AsioTimer(std::shared_ptr<Impl> impl, std::function<void()> on_expiry)
      : impl_(std::move(impl)), alarm_(impl_->add(std::move(on_expiry))) {}
  ~AsioTimer() override { impl_->remove(alarm_); }
  AsioTimer(const AsioTimer&) = delete;
  AsioTimer& operator=(const AsioTimer&) = delete;

  void expire_at(Time deadline) override { impl_->set(*alarm_, deadline); }
  void cancel() override { impl_->set(*alarm_, Time::max()); }

 private:
  std::shared_ptr<Impl> impl_;
  std::shared_ptr<Impl::Alarm> alarm_;
};

AsioScheduler::AsioScheduler(asio::io_context& context) : impl_(std::make_shared<Impl>(context)) {}

Time AsioScheduler::now() const { return std::chrono::steady_clock::now(); }

std::unique_ptr<Timer> AsioScheduler::make_timer(std::function<void()> on_expiry) {
  return std::make_unique<AsioTimer>(impl_, std::move(on_expiry));
}

void AsioScheduler::wait_in_context(bool in_context) { impl_->wait_in_context(in_context); }
Time AsioScheduler::next_deadline() const { return impl_->next_deadline(); }
void AsioScheduler::run_expired() { impl_->run_expired(); }

}  // namespace hystcan::can
