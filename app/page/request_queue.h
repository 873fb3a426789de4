// Queues slow work, so that it does not block the page's thread. One piece of work runs at a time. Clients
// take turns, and the work uses at most half of the thread's time. The regular status message (five times a
// second) and a `stop` are not queued.
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
  /// A piece of work. It must call `done` exactly once, immediately or later.
  using Work = std::function<void(Done done)>;

  static constexpr std::size_t most_of_a_client = 16;

  explicit RequestQueue(boost::asio::io_context& context) : pause_(context) {}

  /// Adds a piece of work of a client. Returns false if `most_of_a_client` pieces of work of this client are
  /// already waiting.
  [[nodiscard]] bool add(std::uint64_t client, Work work);
  void leave(std::uint64_t client) { waiting_.erase(client); }

 private:
  void next();

  boost::asio::steady_timer pause_;
  std::map<std::uint64_t, std::deque<Work>> waiting_;  ///< waiting work by client number; contains only
                                                       ///< clients with work
  std::uint64_t served_last_ = 0;
  bool is_busy_ = false;
};

}  // namespace hystcan::app
