#include "twin/axis.h"

namespace hystcan::twin {

Axis::Axis(const WiredAxisConfig& config, const CommonConfig& common, const can::Database& database,
           can::Scheduler& scheduler, const Connected<node::AmplifierNode>& of_amplifier,
           const Connected<node::SensorNode>& of_sensor)
    : name(config.wire.name),
      wire(config.wire),
      plant(config.axis.plant, scheduler.now()),
      amplifier_device(config.axis.plant.amplifier, plant),
      amplifier(config.wire, config.axis, common, database, scheduler, *of_amplifier.node, amplifier_device),
      sensor_device(Sensor(config.axis.sensor,
                           seed_of(common.seed, wire.sensor_node, of_sensor.node->channels().size()),
                           scheduler.now(), config.axis.plant.substep),
                    plant, scheduler.now()),
      sensor(config.wire, config.axis.sample_clock, database, *of_sensor.node, sensor_device),
      drive_noise(config.axis.drive_noise, config.axis.plant.substep, scheduler.now(),
                  seed_of(common.seed, wire.amplifier_node, amplifier.index())),
      amplifier_line(*of_amplifier.line),
      sensor_line(*of_sensor.line) {
  amplifier_line.add_channel(sent_by(Node::amplifier, database, wire));
  sensor_line.add_channel(sent_by(Node::sensor, database, wire));
  if (!drive_noise.is_silent()) plant.set_drive_noise([this](can::Time time) { return drive_noise(time); });
}

node::BusNode& FaultTarget::node(Node which) const {
  if (which == Node::amplifier) return amplifier.node();
  return sensor.node();
}

}  // namespace hystcan::twin
