#include "controller/requests.h"

#include <boost/lockfree/spsc_queue.hpp>

namespace hystcan::controller {
namespace {

constexpr std::size_t request_capacity = 64;
using RequestRing = boost::lockfree::spsc_queue<Request*, boost::lockfree::capacity<request_capacity>>;

using Refusal = std::optional<std::string_view>;

Refusal refusal_of(LiveSetpoint became) {
  switch (became) {
    case LiveSetpoint::taken:
      return std::nullopt;
    case LiveSetpoint::not_tracking:
      return "the axis does not track a reference";
    case LiveSetpoint::out_of_range:
      break;
  }
  return "the position is outside position_min_um..position_max_um, or of what the model reaches";
}

Refusal enable(Axis& axis) {
  if (axis.state() == AxisState::faulted) return "the axis is faulted: clear the fault first";
  if (axis.state() != AxisState::offline) return enabled_already;
  axis.start(false);
  return std::nullopt;
}

Refusal disable(Axis& axis) {
  if (axis.state() == AxisState::faulted || axis.state() == AxisState::offline)
    return "the axis is not enabled";
  axis.stop();
  return std::nullopt;
}

/// A node whose set-up failed is set up once more.
Refusal clear(WiredAxis& wired) {
  if (wired.axis.is_falling()) return "the drive still ramps to its safe value";
  if (!wired.axis.clear()) return no_fault_to_clear;
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

Refusal carry_out(Request& request, WiredAxes& axes) {
  if (request.axis >= axes.size()) return "there is no such axis";
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
      return refusal_of(axis.go_to(request.position_um));
    case Request::Kind::resume:
      return refusal_of(axis.resume());
    case Request::Kind::retune:
      return axis.retune(*request.tuning);
    case Request::Kind::revert:
      if (ClosedLoop* loop = axis.closed_loop(); loop != nullptr && loop->learning() != nullptr)
        loop->learning()->reset();
      return std::nullopt;
    case Request::Kind::stop:
      for (const auto& each : axes) each->axis.stop();
      return std::nullopt;
  }
  return "not a request";
}

}  // namespace hystcan::controller
