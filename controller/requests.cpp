#include "controller/requests.h"

#include <boost/lockfree/spsc_queue.hpp>

namespace hystcan::controller {
namespace {

constexpr std::size_t request_capacity = 64;
using RequestRing = boost::lockfree::spsc_queue<Request*, boost::lockfree::capacity<request_capacity>>;

std::optional<Refusal> enable(Axis& axis) {
  if (axis.state() == AxisState::faulted) return Refusal::faulted;
  if (axis.state() != AxisState::offline) return Refusal::enabled_already;
  axis.start(false);
  return std::nullopt;
}

std::optional<Refusal> disable(Axis& axis) {
  if (axis.state() == AxisState::faulted || axis.state() == AxisState::offline) return Refusal::not_enabled;
  axis.stop();
  return std::nullopt;
}

/// Clears the fault of the axis. If the set-up of one of its nodes has failed, tries this set-up once more.
std::optional<Refusal> clear(WiredAxis& wired) {
  if (const std::optional<Refusal> refusal = wired.axis.clear()) return refusal;
  for (RemoteNode* node : wired.nodes()) node->retry_setup();
  return std::nullopt;
}

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
  static_cast<void>(request.release());  // the ring owns the request now
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

std::optional<Refusal> carry_out(Request& request, WiredAxes& axes) {
  if (request.axis >= axes.size()) return Refusal::no_such_axis;
  WiredAxis& wired = *axes[request.axis];
  Axis& axis = wired.axis;
  switch (request.kind) {
    case Request::Kind::enable:
      return enable(axis);
    case Request::Kind::disable:
      return disable(axis);
    case Request::Kind::clear:
      return clear(wired);
    case Request::Kind::go_to:
      return axis.go_to(request.position_um);
    case Request::Kind::resume:
      return axis.resume();
    case Request::Kind::retune:
      return axis.retune(*request.tuning);
    case Request::Kind::revert:
      if (ClosedLoop* loop = axis.closed_loop(); loop != nullptr && loop->learning() != nullptr)
        loop->learning()->reset();
      return std::nullopt;
    case Request::Kind::stop:
      for (const auto& each : axes) each->axis.stop();
      break;
  }
  return std::nullopt;
}

}  // namespace hystcan::controller
