#include "twin/twin.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace hystcan::twin {
namespace {

/// Opens a node's connection, at which faults can act, and sets `line` to it.
can::Attach attach_with_faults(const can::Attach& attach, can::Scheduler& scheduler,
                               const FaultyConnection::Config& config, FaultyConnection*& line) {
  return [&attach, &scheduler, config, &line](std::span<const can::Filter> filters) {
    auto connection = std::make_unique<FaultyConnection>(attach(filters), scheduler, config);
    line = connection.get();
    return connection;
  };
}

FaultyConnection::Config sensor_line_config(const can::AxisWire& wire, const can::Database& database,
                                            std::uint64_t seed) {
  return {.node = wire.sensor_node,
          .sends = sent_by(Node::sensor, database, wire),
          .seed = seed + wire.sensor_node};
}

FaultyConnection::Config amplifier_line_config(const can::AxisWire& wire, const can::Database& database,
                                               std::uint64_t seed) {
  const can::Message& command = can::find_message(database, *can::message_map<can::AmpCommand>(wire));
  return {.node = wire.amplifier_node,
          .sends = sent_by(Node::amplifier, database, wire),
          .obeys = can::Filter{.id = command.id, .extended = command.extended},
          .seed = seed + wire.amplifier_node};
}

std::unique_ptr<can::Bus> attach_sensor(const can::AxisWire& wire, const can::Attach& attach) {
  return attach(std::array{can::Filter{can::nmt_id}, can::Filter{can::sync_id},
                           can::Filter{can::heartbeat_base + wire.sensor_node},
                           can::Filter{can::sdo_request_base + wire.sensor_node}});
}

}  // namespace

Axis::Axis(const WiredAxisConfig& config, const CommonConfig& common, const can::Database& database,
           can::Scheduler& scheduler, const can::Attach& attach)
    : name(config.wire.name),
      wire(config.wire),
      plant(config.axis.plant, scheduler.now()),
      amplifier(config, common, database, scheduler,
                attach_with_faults(attach, scheduler, amplifier_line_config(wire, database, common.seed),
                                   amplifier_line),
                plant),
      sensor(config, common, database, scheduler,
             attach_sensor(
                 wire, attach_with_faults(attach, scheduler, sensor_line_config(wire, database, common.seed),
                                          sensor_line)),
             plant),
      drive_noise(config.axis.drive_noise, config.axis.plant.substep, scheduler.now(),
                  common.seed + wire.amplifier_node) {
  if (!drive_noise.is_silent()) plant.set_drive_noise([this](can::Time time) { return drive_noise(time); });
  if (sensor.follows_the_plant()) {
    sensor.follow(scheduler.now(), plant.position_um());
    plant.on_grid([this](can::Time time, double position_um) { sensor.follow(time, position_um); });
  }
}

Config with_axes(Config config, const std::vector<std::string>& names) {
  const auto is_named = [&](const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  };
  for (const std::string& name : names)
    if (std::ranges::none_of(config.axes,
                             [&](const WiredAxisConfig& axis) { return axis.wire.name == name; }))
      throw std::invalid_argument("there is no axis \"" + name + "\", expected one of the configuration's");
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

Twin::Twin(const Config& config, const can::Database& database, can::Scheduler& scheduler,
           const can::Attach& attach)
    : scheduler_(scheduler),
      heartbeat_period_(config.heartbeat_period),
      listened_(scheduler.make_timer([this] { start_nodes(); })) {
  axes_.reserve(config.axes.size());
  for (const WiredAxisConfig& axis : config.axes)
    axes_.push_back(std::make_unique<Axis>(axis, config, database, scheduler, attach));
  for (std::size_t i = 0; i < axes_.size(); ++i)
    for (const model::Coupling& coupling : config.axes[i].axis.couplings)
      axes_[i]->plant.couple(axes_.at(coupling.index)->plant, coupling.um_per_um);
  faults_ = std::make_unique<FaultScheduler>(scheduler, axes_, config.faults, config.random_faults);
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
  started_ = scheduler_.now();
  listened_->expire_at(started_ + heartbeat_period_);
}

void Twin::start_nodes() {
  if (taken_node()) return;
  for (const auto& axis : axes_) {
    axis->amplifier.start();
    axis->sensor.start();
  }
  faults_->start(started_);
}

std::optional<std::uint8_t> Twin::taken_node() const {
  for (const auto& axis : axes_) {
    if (axis->amplifier.is_taken()) return axis->wire.amplifier_node;
    if (axis->sensor.is_taken()) return axis->wire.sensor_node;
  }
  return std::nullopt;
}

std::vector<const can::Bus*> Twin::connections() const {
  std::vector<const can::Bus*> all;
  all.reserve(2 * axes_.size());
  for (const auto& axis : axes_) {
    all.push_back(&axis->amplifier.bus());
    all.push_back(&axis->sensor.bus());
  }
  return all;
}

void Twin::shut_down() {
  faults_->stop();
  for (const auto& axis : axes_) axis->amplifier.shut_down();
}

}  // namespace hystcan::twin
