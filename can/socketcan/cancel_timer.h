#pragma once

namespace hystcan::can {

/// Cancels the waits of an Asio timer, also in a destructor. Asio's cancel() does not fail but is not
/// declared noexcept, and Boost 1.87 no longer has cancel(error_code).
template <class Timer>
void cancel_timer(Timer& timer) noexcept {
  try {
    timer.cancel();
  } catch (...) {
    return;
  }
}

}  // namespace hystcan::can
