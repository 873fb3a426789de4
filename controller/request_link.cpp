#include "controller/request_link.h"

#include <boost/lockfree/spsc_queue.hpp>

namespace hystcan::controller {
namespace {

constexpr std::size_t request_capacity = 64;
using RequestRing = boost::lockfree::spsc_queue<Request*, boost::lockfree::capacity<request_capacity>>;

}  // namespace

struct RequestLink::Rings {
  RequestRing requests;
  RequestRing answers;
};

RequestLink::RequestLink() : rings_(std::make_unique<Rings>()) {}

RequestLink::~RequestLink() {
  const auto free = [](Request* request) { delete request; };
  rings_->requests.consume_all(free);
  rings_->answers.consume_all(free);
}

bool RequestLink::ask(std::unique_ptr<Request> request) {
  if (unanswered_ == request_capacity || !rings_->requests.push(request.get())) return false;
  static_cast<void>(request.release());  // the ring owns it now
  ++unanswered_;
  return true;
}

std::unique_ptr<Request> RequestLink::take_answer() {
  Request* request = nullptr;
  if (!rings_->answers.pop(request)) return nullptr;
  --unanswered_;
  return std::unique_ptr<Request>(request);
}

Request* RequestLink::next() {
  Request* request = nullptr;
  rings_->requests.pop(request);
  return request;
}

void RequestLink::answer(Request* request) { rings_->answers.push(request); }

}  // namespace hystcan::controller
