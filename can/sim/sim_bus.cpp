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

class SimBus::Port final : public SimNode {
 public:
  Port(std::shared_ptr<sim::Wire> wire, TransmitOrder order)
      : wire_(std::move(wire)), node_(wire_->attach(order)) {}
  ~Port() override { wire_->detach(node_); }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  bool send(const Frame& frame) override {
    if (!node_.push(frame)) {
      ++node_.counters.send_refused;
      return false;
    }
    ++node_.counters.sent;
    wire_->contend();
    return true;
  }

  void on_frame(FrameHandler handler) override { node_.on_frame = std::move(handler); }
  bool on_sent(FrameHandler handler) override {
    node_.on_sent = std::move(handler);
    return true;
  }
  void on_state(StateHandler handler) override { node_.on_state = std::move(handler); }
  BusState state() const override { return node_.reported; }
  std::optional<ErrorCounters> error_counters() const override { return node_.confinement.counters(); }
  const BusCounters& counters() const override { return node_.counters; }

  void set_faults(const NodeFaults& faults) override {
    probability(faults.transmit_bit_error, "transmit_bit_error");
    probability(faults.receive_bit_error, "receive_bit_error");
    probability(faults.overrun, "overrun");
    node_.faults = faults;
    wire_->note_faults();
  }
  void restart() override { wire_->request_restart(node_); }

 private:
  std::shared_ptr<sim::Wire> wire_;
  sim::Node& node_;
};

SimBus::SimBus(VirtualClock& clock, std::uint32_t bitrate_bit_per_s, const SimBusConfig& config)
    : wire_(std::make_shared<sim::Wire>(clock, bitrate_bit_per_s, config)) {
  if (bitrate_bit_per_s == 0) throw std::invalid_argument("bit rate 0, expected more than 0");
  probability(config.bit_error, "bit_error");
}
SimBus::~SimBus() = default;

std::unique_ptr<SimNode> SimBus::attach(TransmitOrder order) { return std::make_unique<Port>(wire_, order); }

void SimBus::set_bit_error(double value) { wire_->set_bit_error(probability(value, "bit_error")); }

double SimBus::load() const { return wire_->load(); }

}  // namespace hystcan::can
