#include "can/protocol/node.h"

#include <utility>

namespace hystcan::can {

NmtSlave::NmtSlave(Bus& bus, Scheduler& scheduler, std::uint8_t node, Duration heartbeat_period,
                   ChangeHandler on_change)
    : bus_(bus),
      node_(node),
      scheduler_(scheduler),
      period_(heartbeat_period),
      on_change_(std::move(on_change)),
      heartbeat_(scheduler.make_timer([this] { send_heartbeat(); })) {}

void NmtSlave::boot_up(NmtReset reset) {
  if (id_taken_) return;
  last_reset_ = reset;
  started_ = true;
  state_ = NmtState::boot_up;
  bus_.send(heartbeat_frame(node_, state_));
  on_change_(state_);
  enter(NmtState::pre_operational);
  heartbeat_->expire_at(scheduler_.now() + period_);
}

void NmtSlave::handle(const Frame& frame) {
  if (is_heartbeat_of(node_, frame)) return retire();
  if (frame.id != nmt_id || is_silent()) return;
  const auto nmt = parse_nmt(frame);
  if (!nmt || (nmt->node != 0 && nmt->node != node_)) return;
  switch (nmt->command) {
    case NmtCommand::start:
      return enter(NmtState::operational);
    case NmtCommand::stop:
      return enter(NmtState::stopped);
    case NmtCommand::enter_pre_operational:
      return enter(NmtState::pre_operational);
    case NmtCommand::reset_node:
      return boot_up(NmtReset::node);
    case NmtCommand::reset_communication:
      return boot_up(NmtReset::communication);
  }
}

void NmtSlave::retire() {
  id_taken_ = true;
  heartbeat_->cancel();
  enter(NmtState::stopped);
}

void NmtSlave::enter(NmtState state) {
  if (state == state_) return;
  state_ = state;
  on_change_(state);
}

void NmtSlave::send_heartbeat() {
  bus_.send(heartbeat_frame(node_, state_));
  heartbeat_->expire_at(scheduler_.now() + period_);
}

void HeartbeatMonitor::heard(NmtState state, Time now) {
  if (state == NmtState::boot_up) ++boot_ups_;
  state_ = state;
  last_ = now;
}

std::optional<NmtState> HeartbeatMonitor::state(Time now) const {
  if (!state_ || now - last_ > timeout_) return std::nullopt;
  return state_;
}

}  // namespace hystcan::can
