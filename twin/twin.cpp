#include "twin/twin.h"

#include <array>

namespace hystcan::twin {
namespace {

AmplifierNode::Config amplifier_config(const AxisConfig& axis, const Config& common) {
  const Amplifier::Config& amplifier = axis.plant.amplifier;
  return {.wire = axis.wire,
          .drive_min = amplifier.drive_min,
          .drive_max = amplifier.drive_max,
          .safe_drive = amplifier.safe_drive,
          .command_timeout = axis.command_timeout,
          .heartbeat_period = common.heartbeat_period,
          .status_every = axis.status_every,
          .watchdog_action = axis.watchdog_action,
          .apply = axis.apply};
}

std::unique_ptr<can::Bus> attach_sensor(const can::AxisWire& wire, const can::Attach& attach) {
  return attach(std::array{can::Filter{can::nmt_id}, can::Filter{can::sync_id},
                           can::Filter{can::heartbeat_base + wire.sensor_node},
                           can::Filter{can::sdo_request_base + wire.sensor_node}});
}

}  // namespace

Twin::Axis::Axis(const AxisConfig& config, const Config& common, const can::Database& database,
                 can::Scheduler& scheduler, const can::Attach& attach)
    : name(config.wire.name),
      wire(config.wire),
      plant(config.plant, scheduler.now()),
      amplifier(amplifier_config(config, common), database, scheduler, attach, plant),
      sensor({.wire = config.wire, .heartbeat_period = common.heartbeat_period, .clock = config.sample_clock},
             database, scheduler, attach_sensor(config.wire, attach), plant,
             Sensor(config.sensor, common.seed + config.wire.sensor_node, scheduler.now(),
                    config.plant.substep)),
      drive_noise(config.drive_noise, config.plant.substep, scheduler.now(),
                  common.seed + config.wire.amplifier_node) {
  if (!drive_noise.is_silent()) plant.set_drive_noise([this](can::Time time) { return drive_noise(time); });
  if (sensor.follows_the_plant()) {
    sensor.follow(scheduler.now(), plant.position_um());
    plant.on_grid([this](can::Time time, double position_um) { sensor.follow(time, position_um); });
  }
}

Twin::Twin(const Config& config, const can::Database& database, can::Scheduler& scheduler,
           const can::Attach& attach)
    : scheduler_(scheduler),
      heartbeat_period_(config.heartbeat_period),
      listened_(scheduler.make_timer([this] { start_nodes(); })) {
  for (const AxisConfig& axis : config.axes)
    axes_.push_back(std::make_unique<Axis>(axis, config, database, scheduler, attach));
  for (std::size_t i = 0; i < axes_.size(); ++i)
    for (const Coupling& coupling : config.axes[i].couplings)
      axes_[i]->plant.couple(axes_.at(coupling.index)->plant, coupling.um_per_um);
}

void Twin::start() { listened_->expire_at(scheduler_.now() + heartbeat_period_); }

void Twin::start_nodes() {
  if (taken_node()) return;
  for (const auto& axis : axes_) {
    axis->amplifier.start();
    axis->sensor.start();
  }
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
  for (const auto& axis : axes_) axis->amplifier.shut_down();
}

}  // namespace hystcan::twin
