#include "app/io/bounded_output.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>

namespace hystcan::app {

Written write_within(int descriptor, std::string_view& text, std::chrono::milliseconds patience) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + patience;
  while (!text.empty()) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    pollfd stream{.fd = descriptor, .events = POLLOUT, .revents = 0};
    const int ready = ::poll(&stream, 1, static_cast<int>(std::clamp<long>(left.count(), 0, INT_MAX)));
    if (ready == 0) return Written::timed_out;
    if (ready < 0 && errno != EINTR) return Written::failed;
    if (ready < 0) continue;
    // A pipe that is ready takes PIPE_BUF bytes without waiting.
    const ssize_t written = ::write(descriptor, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
    if (written < 0 && errno != EINTR && errno != EAGAIN) return Written::failed;
    text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
  }
  return Written::all;
}

}  // namespace hystcan::app
