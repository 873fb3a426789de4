#include "node/analogue/analogue_station.h"

#include <cstdint>

#include "node/analogue/device_name.h"

namespace hystcan::node {

Card& Cards::card(const std::string& device) {
  return opened("device", [&]() -> Card& {
    std::unique_ptr<Card>& card = cards_[identity_of(device_named(device))];
    if (!card) card = open_(device);
    return *card;
  });
}

AnalogueAxis::AnalogueAxis(AnalogueDevices& devices, const CommonConfig& common,
                           const can::Database& database, can::Scheduler& scheduler,
                           AmplifierNode& amplifier_node, SensorNode& sensor_node)
    : wire(devices.axis.wire),
      amplifier(wire, devices.axis.config.amplifier, common, database, scheduler, amplifier_node,
                devices.output),
      sensor(wire, {}, database, sensor_node, devices.input) {}

AnalogueStation::AnalogueStation(const AllDevices& devices, const CommonConfig& common,
                                 const can::Database& database, can::Scheduler& scheduler,
                                 const can::Attach& attach)
    : station_(scheduler, common.heartbeat_period) {
  const can::Attach share = [this](std::span<const can::Filter> filters) {
    return connection_.attach(filters);
  };
  std::map<std::uint8_t, AmplifierNode*> amplifiers;
  std::map<std::uint8_t, SensorNode*> sensors;
  for (const auto& one : devices)
    if (AmplifierNode*& node = amplifiers[one->axis.wire.amplifier_node]; node == nullptr)
      node =
          &station_.add(std::make_unique<AmplifierNode>(one->axis.wire, common, database, scheduler, share));
  for (const auto& one : devices)
    if (SensorNode*& node = sensors[one->axis.wire.sensor_node]; node == nullptr)
      node = &station_.add(
          std::make_unique<SensorNode>(one->axis.wire, SampleClock{}, common, database, scheduler, share));
  connection_.open(attach);
  for (const auto& one : devices)
    axes_.push_back(std::make_unique<AnalogueAxis>(*one, common, database, scheduler,
                                                   *amplifiers[one->axis.wire.amplifier_node],
                                                   *sensors[one->axis.wire.sensor_node]));
}

}  // namespace hystcan::node
