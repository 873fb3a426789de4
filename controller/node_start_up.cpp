#include "controller/node_start_up.h"

namespace hystcan::controller {
namespace {

bool send_command(const RemoteNode& node, can::Bus& bus, can::Time now) {
  const auto state = node.state(now);
  if (node.is_set_up() && state != can::NmtState::operational)
    return bus.send(can::nmt_frame({can::NmtCommand::start, node.node()}));
  if (!node.is_set_up() && state == can::NmtState::stopped)
    return bus.send(can::nmt_frame({can::NmtCommand::enter_pre_operational, node.node()}));
  return false;
}

}  // namespace

void NodeStartUp::begin_period() {
  if (state_.next_to_command >= node_count()) state_.next_to_command = 0;
}

bool NodeStartUp::send_next(can::Bus& bus, can::Time now, double time_s) {
  return send_next_setup_request(bus, now, time_s) || send_next_command(bus, now);
}

bool NodeStartUp::send_next_setup_request(can::Bus& bus, can::Time now, double time_s) {
  for (std::size_t tried = 0; tried < node_count(); ++tried) {
    const std::size_t place = state_.next_to_set_up;
    state_.next_to_set_up = (place + 1) % node_count();
    Axis& axis = axes_[place / 2]->axis;
    if (axis.state() != AxisState::waiting) continue;
    RemoteNode& node = node_at(place);
    const auto request = node.poll_setup(now);
    if (node.setup_has_failed()) axis.trip(Cause::node_not_set_up, time_s);
    if (!request) continue;
    bus.send(*request);
    return true;
  }
  return false;
}

bool NodeStartUp::send_next_command(can::Bus& bus, can::Time now) {
  while (state_.next_to_command < node_count()) {
    const std::size_t place = state_.next_to_command++;
    if (axes_[place / 2]->axis.state() == AxisState::waiting && send_command(node_at(place), bus, now))
      return true;
  }
  return false;
}

RemoteNode& NodeStartUp::node_at(std::size_t place) { return *axes_[place / 2]->nodes()[place % 2]; }

}  // namespace hystcan::controller
