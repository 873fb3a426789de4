// The time limit of a test. Nothing else in a test depends on the clock of the host.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <chrono>
#include <string>
#include <thread>

namespace hystcan::support {

/// Ends a test that hangs: the only limit in host time besides the TIMEOUT of ctest.
inline constexpr std::chrono::seconds patience{120};

/// Returns `patience` as the value of a command's option --timeout.
inline std::string patience_s() { return std::to_string(patience.count()); }

/// Waits until `condition` is true. Returns false if that takes longer than `patience`.
template <class Condition>
[[nodiscard]] bool eventually(Condition condition) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + patience;
  while (!condition()) {
    if (Clock::now() > end) return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

/// Makes recv() on the socket fail after `patience`.
inline void limit_receive(int socket) {
  const timeval limit{.tv_sec = patience.count(), .tv_usec = 0};
  EXPECT_EQ(setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit), 0);
}

}  // namespace hystcan::support
