#include "can/sim/sim_bus.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "can/sim/sim_wire.h"

namespace hystcan::can {
namespace {

double probability(double value, const char* name) {
  if (!(value >= 0.0 && value <= 1.0))
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) + ", expected 0 to 1");
  return value;
}

}  // namespace

SimNode::SimNode(std::shared_ptr<sim::Wire> wire, TransmitOrder order, std::span<const Filter> filters)
    : wire_(std::move(wire)), node_(wire_->attach(order, filters)) {}
SimNode::~SimNode() { wire_->detach(node_); }

bool SimNode::send(const Frame& frame) {
  if (!wire_->send(node_, frame)) {
    ++node_.counters.send_refused;
    return false;
  }
  ++node_.counters.sent;
  return true;
}

void SimNode::on_frame(FrameHandler handler) { node_.on_frame = std::move(handler); }
bool SimNode::on_sent(FrameHandler handler) {
  node_.on_sent = std::move(handler);
  return true;
}
void SimNode::on_state(StateHandler handler) { node_.on_state = std::move(handler); }
BusState SimNode::state() const { return node_.reported; }
std::optional<ErrorCounters> SimNode::error_counters() const { return node_.confinement.counters(); }
const BusCounters& SimNode::counters() const { return node_.counters; }

void SimNode::set_faults(const NodeFaults& faults) {
  probability(faults.transmit_bit_error, "transmit_bit_error");
  probability(faults.receive_bit_error, "receive_bit_error");
  probability(faults.overrun, "overrun");
  node_.faults = faults;
  wire_->note_faults();
}
void SimNode::restart() { wire_->request_restart(node_); }

SimBus::SimBus(VirtualClock& clock, const BitRates& rates, const SimBusConfig& config)
    : wire_(std::make_shared<sim::Wire>(clock, rates, config)) {
  if (rates.nominal_bit_per_s == 0) throw std::invalid_argument("bit rate 0, expected more than 0");
  probability(config.bit_error, "bit_error");
}
SimBus::~SimBus() = default;

std::unique_ptr<SimNode> SimBus::attach(TransmitOrder order, std::span<const Filter> filters) {
  return std::make_unique<SimNode>(wire_, order, filters);
}

void SimBus::set_bit_error(double value) { wire_->set_bit_error(probability(value, "bit_error")); }

double SimBus::load() const { return wire_->load(); }

}  // namespace hystcan::can
