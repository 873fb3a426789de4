// The scheduler on Boost.Asio, in real time.
#pragma once

#include <functional>
#include <memory>

#include "can/scheduler.h"

namespace boost::asio {
class io_context;
}

namespace hystcan::can {

/// The scheduler of an io_context, with the steady clock and absolute deadlines.
class AsioScheduler final : public Scheduler {
 public:
  explicit AsioScheduler(boost::asio::io_context& context) : context_(context) {}
  Time now() const override;
  std::unique_ptr<Timer> make_timer(std::function<void()> on_expiry) override;

 private:
  boost::asio::io_context& context_;
};

}  // namespace hystcan::can
