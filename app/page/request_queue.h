// Work that takes the page's thread for a while: one piece at a time, the clients in turn, and at most half
// of the time. What comes five times a second, and stopping, does not wait behind it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>

namespace hystcan::app {

class RequestQueue {
 public:
  using Done = std::function<void()>;
  /// Calls `done` once, now or later.
  using Work = std::function<void(Done done)>;

  static constexpr std::size_t most_of_a_client = 16;

  explicit RequestQueue(boost::asio::io_context& context) : pause_(context) {}

  /// False if so many of this client wait already.
  [[nodiscard]] bool add(std::uint64_t client, Work work);
  void leave(std::uint64_t client) { waiting_.erase(client); }

 private:
  void next();

  boost::asio::steady_timer pause_;
  std::map<std::uint64_t, std::deque<Work>> waiting_;  ///< none is empty
  std::uint64_t served_last_ = 0;
  bool is_busy_ = false;
};

}  // namespace hystcan::app
