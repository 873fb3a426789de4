// Queues work that occupies the page's thread for a while. The pieces run one at a time, for each client in
// turn, in at most half of the thread's time. The periodic status, five times a second, and a stop do not
// wait for this queue.
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
  /// Must call `done` once, immediately or later.
  using Work = std::function<void(Done done)>;

  static constexpr std::size_t most_of_a_client = 16;

  explicit RequestQueue(boost::asio::io_context& context) : pause_(context) {}

  /// Returns false if this client already has too many waiting pieces.
  [[nodiscard]] bool add(std::uint64_t client, Work work);
  void leave(std::uint64_t client) { waiting_.erase(client); }

 private:
  void next();

  boost::asio::steady_timer pause_;
  std::map<std::uint64_t, std::deque<Work>> waiting_;  ///< no queue is empty
  std::uint64_t served_last_ = 0;
  bool is_busy_ = false;
};

}  // namespace hystcan::app
