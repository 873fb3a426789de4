// Any number of copies of axis x of the shipped piezo stage, on one bus.
//
// The first axis has nodes 1 and 2, the next one 3 and 4, and so on. Commands have the highest priority
// (0x100 + axis), so that they never wait for the samples of other axes: the transmit queue is short.
#pragma once

#include <string>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::support {

inline std::string database_text(std::size_t axes) {
  const std::string guards =
      " SG_ Counter : 48|4@1+ (1,0) [0|15] \"\"  Node\n SG_ Crc : 56|8@1+ (1,0) [0|255] \"\"  Node\n\n";
  const auto message = [&](std::size_t id, const std::string& name, const std::string& signals) {
    return "BO_ " + std::to_string(id) + " " + name + ": 8 Node\n" + signals + guards;
  };
  std::string text = "VERSION \"1.0\"\n\nNS_ :\n\nBS_:\n\nBU_: Node\n\n";
  for (std::size_t i = 0; i < axes; ++i) {
    const std::string prefix = "A" + std::to_string(i);
    text += message(0x100 + i, prefix + "AmpCommand",
                    " SG_ Setpoint : 0|32@1- (1e-06,0) [-1000|1000] \"V\"  Node\n"
                    " SG_ Enable : 32|1@1+ (1,0) [0|1] \"\"  Node\n"
                    " SG_ ClearFault : 33|1@1+ (1,0) [0|1] \"\"  Node\n"
                    " SG_ SyncCounter : 40|8@1+ (1,0) [0|240] \"\"  Node\n");
    text += message(0x181 + 2 * i, prefix + "AmpStatus",
                    " SG_ Output : 0|32@1- (1e-06,0) [-1000|1000] \"V\"  Node\n"
                    " SG_ State : 32|8@1+ (1,0) [0|3] \"\"  Node\n"
                    " SG_ Fault : 40|8@1+ (1,0) [0|255] \"\"  Node\n");
    text += message(0x182 + 2 * i, prefix + "SensorSample",
                    " SG_ Position : 0|32@1- (1e-06,0) [-2000|2000] \"um\"  Node\n"
                    " SG_ SyncCounter : 32|8@1+ (1,0) [0|240] \"\"  Node\n"
                    " SG_ Status : 40|8@1+ (1,0) [0|255] \"\"  Node\n");
  }
  return text;
}

/// The bit rate is proportional to the number of axes, so that each axis always has the same share of the
/// bus.
inline rehearsal::Setup many_axes(const config::Config& config, std::size_t axes) {
  rehearsal::Setup setup{.controller = controller_config(config),
                         .twin = twin_config(config),
                         .database = can::parse_dbc(database_text(axes), "axes"),
                         .rates = {.nominal_bit_per_s = static_cast<std::uint32_t>(1'000'000 * axes)}};
  const controller::WiredAxisConfig control = setup.controller.axes.front();
  const twin::WiredAxisConfig twin = setup.twin.axes.front();
  setup.controller.axes.assign(axes, control);
  setup.twin.axes.assign(axes, twin);
  for (std::size_t i = 0; i < axes; ++i) {
    can::AxisWire wire = control.wire;
    wire.name = "a" + std::to_string(i);
    wire.message_prefix = "A" + std::to_string(i);
    wire.amplifier_node = static_cast<std::uint8_t>(2 * i + 1);
    wire.sensor_node = static_cast<std::uint8_t>(2 * i + 2);
    setup.controller.axes[i].wire = setup.twin.axes[i].wire = wire;
    setup.controller.axes[i].axis.repeat = true;
  }
  return setup;
}

}  // namespace hystcan::support
