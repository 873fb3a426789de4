// The keys of the configuration table [axis.analogue]: an amplifier and a sensor that are connected to an
// analogue I/O card.
#pragma once

#include "config/document/document.h"
#include "node/analogue/config.h"

namespace hystcan::config {

/// Range of the keys volts_per_drive and position_um_per_V. Both may be negative, because an amplifier or a
/// sensor may invert.
inline constexpr Range scale_range{.lo = 1e-6, .hi = 1e6, .either_sign = true};
inline constexpr Range subdevice_range{.lo = 0.0, .hi = 255.0};
inline constexpr Range channel_range{.lo = 0.0, .hi = 65'535.0};

template <class V>
void visit(V& v, node::CardChannel& place) {
  v.optional("device", place.device, any, {"the card with the channel", "that of the axis"});
  v.optional("subdevice", place.subdevice, subdevice_range, {"number of the subdevice of comedi"});
  v.required("channel", place.channel, channel_range, {"number of the channel"});
  v.optional("range", place.range, any, {"range of the converter: `0..10 V`", "first range of the channel"});
  v.optional("reference", place.reference, any, {"reference potential of the channel's voltage"});
}

template <class V>
void visit(V& v, node::InputConfig& input) {
  visit(v, input.place);
  v.optional("average", input.average, {.lo = 1, .hi = 1000},
             {"number of conversions that are averaged for each sample"});
}

template <class V>
void visit(V& v, node::LineConfig& line) {
  v.optional("device", line.place.device, any, {"the card with the line", "that of the axis"});
  v.optional("subdevice", line.place.subdevice, subdevice_range, {"number of the subdevice of comedi"});
  v.required("line", line.place.channel, channel_range, {"number of the digital line"});
  v.optional("active", line.active, any, {"level at which the line is active"});
}

template <class V>
void visit(V& v, node::AnalogueConfig& a) {
  v.takes_effect(Effect::on_nodes);
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.required(
      "device", a.device, any,
      {"the card: `comedi:/dev/comedi0`, `iio:ad5791`, or `simulated` for the stage of `[axis.twin]`"});
  v.table("drive_output", a.drive_output, plain);
  v.required("volts_per_drive", a.volts_per_drive, scale_range,
             {"volts at the card's output for one unit of the drive; 0.1 for an amplifier of 10 V/V"});
  v.table("position_input", a.position_input, plain);
  v.required("position_um_per_V", a.position_um_per_V, scale_range, {"scale of the sensor"});
  v.optional("position_zero_um", a.position_zero_um, {.lo = -1e6, .hi = 1e6},
             {"position if the sensor's voltage is 0 V"});
  v.optional_table("output_input", a.output_input, plain);
  v.optional_table("enable_line", a.enable_line, plain);
  v.optional_table("interlock_line", a.interlock_line, plain);
  v.optional_table("charge_pump_line", a.charge_pump_line, plain);
  v.optional("enable_delay_ms", a.amplifier.enable_delay, {.lo = 0.0, .hi = 10'000.0},
             {"time from the signal on the enable line until the amplifier connects its output"});
  v.optional("command_timeout_ms", a.amplifier.command_timeout, {.lo = 0.1, .hi = 10'000.0},
             {"time without a command after which the amplifier's watchdog trips, at least two cycles"});
  v.optional("status_every", a.amplifier.status_every, {.lo = 1, .hi = 1000},
             {"period of `AmpStatus` in SYNCs"});
}

}  // namespace hystcan::config
