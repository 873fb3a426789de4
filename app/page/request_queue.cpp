#include "app/page/request_queue.h"

#include <chrono>
#include <utility>

namespace hystcan::app {

bool RequestQueue::add(std::uint64_t client, Work work) {
  std::deque<Work>& own = waiting_[client];
  if (own.size() >= most_of_a_client) return false;
  own.push_back(std::move(work));
  if (!is_busy_) next();
  return true;
}

void RequestQueue::next() {
  if (waiting_.empty()) {
    is_busy_ = false;
    return;
  }
  is_busy_ = true;
  auto turn = waiting_.upper_bound(served_last_);
  if (turn == waiting_.end()) turn = waiting_.begin();
  served_last_ = turn->first;
  const Work work = std::move(turn->second.front());
  turn->second.pop_front();
  if (turn->second.empty()) waiting_.erase(turn);
  using Clock = std::chrono::steady_clock;
  work([this, began = Clock::now()] {
    pause_.expires_after(Clock::now() - began);
    pause_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) next();
    });
  });
}

}  // namespace hystcan::app
