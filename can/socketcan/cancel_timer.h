#pragma once

namespace hystcan::can {

/// Cancels the waits of an Asio timer without an exception, for use in a destructor. Asio's cancel() does not
/// fail, but it is not declared noexcept, and Boost 1.87 no longer has cancel(error_code).
template <class Timer>
void cancel_timer(Timer& timer) noexcept {
  try {
    timer.cancel();
  } catch (...) {
    return;
  }
}

}  // namespace hystcan::can
