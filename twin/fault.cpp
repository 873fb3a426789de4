#include "twin/fault.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::twin {
namespace {

using enum Fault;

constexpr std::array<FaultTraits, fault_count> kinds{{
    {no_reply, "no_reply", FaultSite::either_node},
    {late, "late", FaultSite::either_node, "cycles", 1.0, 1.0, 16.0},
    {duplicate, "duplicate", FaultSite::either_node},
    {out_of_order, "out_of_order", FaultSite::either_node},
    {frozen_value, "frozen_value", FaultSite::either_node},
    {frozen_counter, "frozen_counter", FaultSite::either_node},
    {wrong_crc, "wrong_crc", FaultSite::either_node},
    {wrong_length, "wrong_length", FaultSite::either_node},
    {wrong_id_type, "wrong_id_type", FaultSite::either_node},
    {out_of_range, "out_of_range", FaultSite::sensor, "um", 1000.0, -1e9, 1e9},
    {sensor_bad_status, "sensor_bad_status", FaultSite::sensor},
    {no_heartbeat, "no_heartbeat", FaultSite::either_node},
    // The default 0x5000 is the error code "device hardware" of CiA 301.
    {emergency, "emergency", FaultSite::either_node, "error code", 0x5000, 1.0, 0xFFFF},
    {error_passive, "error_passive", FaultSite::either_node, "of the frames missed", 0.3, 0.0, 1.0},
    {babbling_node, "babbling_node", FaultSite::either_node, "frames/s", 5000.0, 1.0, 20'000.0},
    {watchdog_trip, "watchdog_trip", FaultSite::amplifier},
    {amplifier_trip, "amplifier_trip", FaultSite::amplifier},
    {node_reboot, "node_reboot", FaultSite::either_node},
    {bus_off, "bus_off", FaultSite::either_node},
    {parameter_drift, "parameter_drift", FaultSite::plant, "of the travel", -0.1, -0.9, 9.0},
    {resonance_shift, "resonance_shift", FaultSite::plant, "of the natural frequency", -0.2, -0.9, 9.0},
    {load_step, "load_step", FaultSite::plant, "um", 1.0, -1e6, 1e6},
    {limited_output, "limited_output", FaultSite::amplifier, "drive units", 0.0, 0.0, 1e6},
    {sensor_gain, "sensor_gain", FaultSite::sensor, "times", -1.0, -1e3, 1e3},
    {sensor_offset, "sensor_offset", FaultSite::sensor, "um", 8.0, -1e6, 1e6},
    {relay_opens, "relay_opens", FaultSite::amplifier},
}};

constexpr bool are_in_the_order_of_fault() {
  for (std::size_t i = 0; i < fault_count; ++i)
    if (static_cast<std::size_t>(kinds[i].kind) != i) return false;
  return true;
}
static_assert(are_in_the_order_of_fault());

/// Returns a message if the axis's frame lacks the field that the fault changes; nullopt otherwise.
std::optional<std::string> missing_field(Fault kind, Node node, const can::AxisWire& wire) {
  const bool by_sensor = node == Node::sensor;
  const auto map =
      by_sensor ? can::message_map<can::SensorSample>(wire) : can::message_map<can::AmpStatus>(wire);
  const auto require = [&](bool has_it, std::string_view what) -> std::optional<std::string> {
    if (has_it) return std::nullopt;
    return fmt::format("message {} has no {}, expected a message with this signal", map->message, what);
  };
  switch (kind) {
    case late:
    case duplicate:
    case out_of_order:
    case wrong_length:
    case wrong_id_type:
    case frozen_value:
    case frozen_counter:
    case wrong_crc:
      if (!map) return "the amplifier sends no status, expected an amplifier with a status message";
      break;
    default:
      break;
  }
  switch (kind) {
    case frozen_value:
      return require(map->carries(by_sensor ? "position" : "output"), "value");
    case frozen_counter:
      return require(map->integrity != can::Integrity::none, "counter");
    case wrong_crc:
      return require(map->integrity == can::Integrity::counter_crc, "CRC");
    case sensor_bad_status:
      return require(map->carries("status"), "status");
    default:
      return std::nullopt;
  }
}

}  // namespace

const FaultTraits& traits(Fault kind) { return kinds[static_cast<std::size_t>(kind)]; }

bool acts_on_one_axis(Fault kind) {
  switch (traits(kind).site) {
    case FaultSite::either_node:
      return kind == frozen_value;
    case FaultSite::amplifier:
      return kind != watchdog_trip;
    default:
      return true;
  }
}

const std::array<std::string_view, fault_count>& words(Fault) {
  static const std::array<std::string_view, fault_count> names = [] {
    std::array<std::string_view, fault_count> all;
    std::ranges::transform(kinds, all.begin(), &FaultTraits::name);
    return all;
  }();
  return names;
}

FaultSpec fault_spec(Fault kind, std::string axis) {
  const FaultTraits& kind_traits = traits(kind);
  return {.kind = kind,
          .axis = std::move(axis),
          .node = kind_traits.site == FaultSite::amplifier ? Node::amplifier : Node::sensor,
          .value = kind_traits.value};
}

std::string describe(const FaultSpec& spec) {
  const FaultTraits& kind_traits = traits(spec.kind);
  const std::string_view place = kind_traits.site == FaultSite::plant ? "stage" : to_string(spec.node);
  std::string text = fmt::format("{} of {}: {}", place, spec.axis, kind_traits.name);
  if (!kind_traits.unit.empty()) text += fmt::format(", {:g} {}", spec.value, kind_traits.unit);
  return text;
}

std::optional<std::string> reason_against(const FaultSpec& spec, const can::AxisWire& wire) {
  const FaultTraits& kind_traits = traits(spec.kind);
  const bool wrong_node = (kind_traits.site == FaultSite::sensor && spec.node != Node::sensor) ||
                          (kind_traits.site == FaultSite::amplifier && spec.node != Node::amplifier);
  if (wrong_node)
    return fmt::format("{0} is a fault of the {1}, expected node = \"{1}\"", kind_traits.name,
                       kind_traits.site == FaultSite::sensor ? "sensor" : "amplifier");
  if (!kind_traits.unit.empty() && !(spec.value >= kind_traits.lowest && spec.value <= kind_traits.highest))
    return fmt::format("{}: value is {:g} {}, expected {:g} to {:g}", kind_traits.name, spec.value,
                       kind_traits.unit, kind_traits.lowest, kind_traits.highest);
  if ((spec.kind == late || spec.kind == emergency) && spec.value != std::round(spec.value))
    return fmt::format("{}: value is {:g}, expected a whole number", kind_traits.name, spec.value);
  if (spec.lasts < can::Duration::zero())
    return fmt::format("{}: the duration is {:g} s, expected at least 0", kind_traits.name,
                       can::seconds(spec.lasts));
  if (spec.kind == parameter_drift && spec.lasts == can::Duration::zero())
    return "parameter_drift: the duration is 0 s, expected a duration above 0 s";
  const auto missing = missing_field(spec.kind, spec.node, wire);
  if (!missing) return std::nullopt;
  return fmt::format("{}: {}", kind_traits.name, *missing);
}

}  // namespace hystcan::twin
