// The nodes of `hystcan node` on a simulated card, with the faults of the twin and of a card.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/schema/config.h"
#include "node/analogue/analogue_station.h"
#include "twin/fault_scheduler.h"
#include "twin/simulated_card.h"

namespace hystcan::support {

/// A card on which a test can change the converted voltages by the functions `position`, `monitor` and
/// `drive`. An empty function changes nothing.
class FaultyCard final : public node::Card {
 public:
  explicit FaultyCard(std::unique_ptr<node::Card> card) : card_(std::move(card)) {}

  using Reading = std::function<std::optional<double>(double volts)>;
  Reading position{};
  Reading monitor{};
  /// Returns the voltage that the converter receives; `nullopt`: the conversion fails.
  Reading drive{};
  bool interlock_is_active = false;

  std::unique_ptr<node::VoltageOutput> output(const node::CardChannel& place) override {
    return std::make_unique<Output>(card_->output(place), drive);
  }
  std::unique_ptr<node::VoltageInput> input(const node::CardChannel& place) override {
    return std::make_unique<Input>(card_->input(place), place.channel == 0 ? position : monitor);
  }
  std::unique_ptr<node::LineOutput> line_output(const node::CardChannel& place) override {
    return card_->line_output(place);
  }
  std::unique_ptr<node::LineInput> line_input(const node::CardChannel&) override {
    return std::make_unique<Line>(interlock_is_active);
  }
  node::VoltageRange check_output(const node::CardChannel& place) override {
    return card_->check_output(place);
  }
  void check_line_output(const node::CardChannel&) override {}
  void check_line_input(const node::CardChannel&) override {}

 private:
  struct Output final : node::VoltageOutput {
    Output(std::unique_ptr<node::VoltageOutput> real, const Reading& changed)
        : output(std::move(real)), change(changed) {}
    const node::VoltageRange& range() const override { return output->range(); }
    bool write(double volts) override {
      const std::optional<double> changed = change ? change(volts) : volts;
      return changed && output->write(*changed);
    }
    std::unique_ptr<node::VoltageOutput> output;
    const Reading& change;
  };
  struct Input final : node::VoltageInput {
    Input(std::unique_ptr<node::VoltageInput> real, const Reading& changed)
        : input(std::move(real)), change(changed) {}
    const node::VoltageRange& range() const override { return input->range(); }
    std::optional<double> read() override {
      const std::optional<double> volts = input->read();
      return volts && change ? change(*volts) : volts;
    }
    std::unique_ptr<node::VoltageInput> input;
    const Reading& change;
  };
  struct Line final : node::LineInput {
    explicit Line(const bool& level) : is_high(level) {}
    std::optional<bool> read() override { return is_high; }
    const bool& is_high;
  };

  std::unique_ptr<node::Card> card_;
};

/// Both nodes share one connection: a fault that stops the connection stops both nodes.
class CardNodes {
 public:
  CardNodes(const config::Config& config, can::Scheduler& scheduler, const can::Attach& attach)
      : scheduler_(scheduler),
        axes_(analogue_axes(config)),
        twin_(twin_config(config)),
        cards_([this](const std::string& device) {
          auto simulated = std::make_unique<twin::SimulatedCard>(device, twin_, axes_, scheduler_);
          simulated_ = simulated.get();
          auto faulty = std::make_unique<FaultyCard>(std::move(simulated));
          card_ = faulty.get();
          return faulty;
        }),
        devices_([this] {
          node::AllDevices all;
          all.push_back(std::make_unique<node::AnalogueDevices>(axes_.front(), cards_));
          return all;
        }()),
        station_(devices_, twin_, config.database, scheduler, [&](std::span<const can::Filter> filters) {
          const auto command = can::find_layout<can::AmpCommand>(config.database, wire());
          auto amplifier = line(attach(filters), wire().amplifier_node,
                                can::Filter{.id = command->id(), .extended = command->extended()});
          amplifier_line_ = amplifier.get();
          auto sensor = line(std::move(amplifier), wire().sensor_node, {});
          sensor_line_ = sensor.get();
          return sensor;
        }) {
    amplifier_line_->add_channel(twin::sent_by(twin::Node::amplifier, config.database, wire()));
    sensor_line_->add_channel(twin::sent_by(twin::Node::sensor, config.database, wire()));
    faults_.emplace(scheduler, std::vector{fault_target()}, twin_.faults, twin_.random_faults);
  }

  void start() {
    station_.station().start([this, started = scheduler_.now()] { faults_->start(started); });
  }
  twin::FaultTarget fault_target() {
    node::AnalogueAxis& axis = *station_.axes().front();
    return {wire(),       simulated_->plant(wire().name), axis.amplifier, axis.sensor, *amplifier_line_,
            *sensor_line_};
  }
  twin::FaultScheduler& faults() { return *faults_; }
  FaultyCard& card() { return *card_; }

 private:
  const can::AxisWire& wire() const { return axes_.front().wire; }
  std::unique_ptr<twin::FaultyConnection> line(std::unique_ptr<can::Bus> within, std::uint8_t node,
                                               std::optional<can::Filter> obeys) {
    return std::make_unique<twin::FaultyConnection>(
        std::move(within), scheduler_,
        twin::FaultyConnection::Config{.node = node, .obeys = obeys, .seed = twin_.seed + node});
  }

  can::Scheduler& scheduler_;
  std::vector<node::WiredAnalogueAxis> axes_;
  twin::Config twin_;
  twin::SimulatedCard* simulated_ = nullptr;
  FaultyCard* card_ = nullptr;
  twin::FaultyConnection* amplifier_line_ = nullptr;
  twin::FaultyConnection* sensor_line_ = nullptr;
  node::Cards cards_;
  node::AllDevices devices_;
  node::AnalogueStation station_;
  std::optional<twin::FaultScheduler> faults_;
};

}  // namespace hystcan::support
