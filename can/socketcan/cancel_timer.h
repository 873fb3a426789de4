#pragma once

namespace hystcan::can {

/// Ends the waits of a timer of Asio, in a destructor too. Its cancel() does not fail, but is not declared
/// noexcept, and Boost 1.87 has no cancel(error_code) any more.
template <class Timer>
void cancel_timer(Timer& timer) noexcept {
  try {
    timer.cancel();
  } catch (...) {
    return;
  }
}

}  // namespace hystcan::can
