#include "twin/twin.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace hystcan::twin {
namespace {

bool share_a_node(const can::AxisWire& one, const can::AxisWire& other) {
  return one.amplifier_node == other.amplifier_node || one.sensor_node == other.sensor_node;
}

}  // namespace

Config with_axes(Config config, const std::vector<std::string>& names) {
  const auto is_named = [&](const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  };
  for (const std::string& name : names)
    if (std::ranges::none_of(config.axes,
                             [&](const WiredAxisConfig& axis) { return axis.wire.name == name; }))
      throw std::invalid_argument("there is no axis \"" + name + "\", expected an axis of the configuration");
  for (const WiredAxisConfig& kept : config.axes)
    for (const WiredAxisConfig& left : config.axes)
      if (is_named(kept.wire.name) && !is_named(left.wire.name) && share_a_node(kept.wire, left.wire))
        throw std::invalid_argument("axes \"" + kept.wire.name + "\" and \"" + left.wire.name +
                                    "\" share a node, expected both axes or neither axis in the twin");
  std::erase_if(config.axes, [&](const WiredAxisConfig& axis) { return !is_named(axis.wire.name); });
  std::erase_if(config.faults, [&](const FaultSpec& order) { return !is_named(order.axis); });
  for (WiredAxisConfig& axis : config.axes) {
    std::erase_if(axis.axis.couplings,
                  [&](const model::Coupling& coupling) { return !is_named(coupling.from); });
    for (model::Coupling& coupling : axis.axis.couplings)
      coupling.index = static_cast<std::size_t>(
          std::ranges::find(config.axes, coupling.from,
                            [](const WiredAxisConfig& one) { return one.wire.name; }) -
          config.axes.begin());
  }
  return config;
}

template <class Made, class... Arguments>
Connected<Made> Twin::connect(const can::Attach& attach, const FaultyConnection::Config& config,
                              const Arguments&... arguments) {
  Connected<Made> made;
  const auto through_faults = [&](std::span<const can::Filter> filters) {
    auto line = std::make_unique<FaultyConnection>(attach(filters), scheduler_, config);
    made.line = line.get();
    return line;
  };
  made.node = &station_.add(std::make_unique<Made>(arguments..., scheduler_, through_faults));
  return made;
}

Twin::Twin(const Config& config, const can::Database& database, can::Scheduler& scheduler,
           const can::Attach& attach)
    : scheduler_(scheduler), station_(scheduler, config.heartbeat_period) {
  axes_.reserve(config.axes.size());
  for (const WiredAxisConfig& axis : config.axes) {
    Connected<node::AmplifierNode> amplifier;
    Connected<node::SensorNode> sensor;
    for (const auto& other : axes_) {
      if (other->wire.amplifier_node == axis.wire.amplifier_node)
        amplifier = {&other->amplifier.node(), &other->amplifier_line};
      if (other->wire.sensor_node == axis.wire.sensor_node)
        sensor = {&other->sensor.node(), &other->sensor_line};
    }
    if (amplifier.node == nullptr) {
      const auto command = can::find_layout<can::AmpCommand>(database, axis.wire);
      amplifier = connect<node::AmplifierNode>(
          attach,
          {.node = axis.wire.amplifier_node,
           .obeys = can::Filter{.id = command->id(), .extended = command->extended()},
           .seed = config.seed + axis.wire.amplifier_node},
          axis.wire, config, database);
    }
    if (sensor.node == nullptr)
      sensor = connect<node::SensorNode>(
          attach, {.node = axis.wire.sensor_node, .seed = config.seed + axis.wire.sensor_node}, axis.wire,
          axis.axis.sample_clock, config, database);
    axes_.push_back(std::make_unique<Axis>(axis, config, database, scheduler, amplifier, sensor));
  }
  for (std::size_t i = 0; i < axes_.size(); ++i)
    for (const model::Coupling& coupling : config.axes[i].axis.couplings)
      axes_[i]->plant.couple(axes_.at(coupling.index)->plant, coupling.um_per_um);
  std::vector<FaultTarget> targets;
  for (const auto& axis : axes_) targets.push_back(axis->fault_target());
  faults_ =
      std::make_unique<FaultScheduler>(scheduler, std::move(targets), config.faults, config.random_faults);
}

void Twin::on_truth(const TruthHandler& handler) {
  for (std::size_t i = 0; i < axes_.size(); ++i)
    axes_[i]->sensor.on_sample(
        [handler, i, &axis = *axes_[i]](can::Time time, const can::SensorSample& sample) {
          handler({.time = time,
                   .axis = i,
                   .sync_counter = sample.sync_counter,
                   .setpoint = axis.amplifier.setpoint(),
                   .drive = axis.plant.drive(),
                   .hysteresis_um = axis.plant.hysteresis_um(),
                   .position_um = axis.plant.position_um(),
                   .measured_um = sample.position_um});
        });
}

void Twin::start() {
  station_.start([this, started = scheduler_.now()] { faults_->start(started); });
}

void Twin::shut_down() {
  faults_->stop();
  station_.shut_down();
}

}  // namespace hystcan::twin
