// A simulated analogue I/O card: its converters are connected to simulated stages.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "node/analogue/config.h"
#include "twin/config.h"
#include "twin/simulated_amplifier.h"
#include "twin/simulated_sensor.h"

namespace hystcan::twin {

// The card simulates each channel that an axis names in its section [axis.analogue] of the configuration:
//
//   drive_output     amplifier of [axis.twin], target = volts / volts_per_drive
//   position_input   volts = (reading of the sensor of [axis.twin] - position_zero) / position_um_per_V
//   output_input     volts = volts_per_drive * output of the amplifier
//   enable_line and charge_pump_line have no effect; interlock_line is never active
//
// A converter of N bits has the range [lo, hi], -10..10 V or 0..10 V. It rounds a voltage v to a multiple of
// its step:
//
//   step = (hi - lo) / (2^N - 1),   volts = lo + step round((min(max(v, lo), hi) - lo) / step)

class SimulatedCard final : public node::Card {
 public:
  /// Returns the voltage range with the name place.range, for a converter of `bits` bits. Throws
  /// node::ChannelError if the card has no such range.
  static node::VoltageRange range_of(unsigned bits, const node::CardChannel& place);

  /// Simulates the stages of the axes whose `device` is `name` (see node::DeviceName). Throws Error if `name`
  /// is not a valid device name.
  SimulatedCard(const std::string& name, const Config& config,
                const std::vector<node::WiredAnalogueAxis>& axes, can::Scheduler& scheduler);
  ~SimulatedCard() override;

  std::unique_ptr<node::VoltageOutput> output(const node::CardChannel& place) override;
  std::unique_ptr<node::VoltageInput> input(const node::CardChannel& place) override;
  std::unique_ptr<node::LineOutput> line_output(const node::CardChannel& place) override;
  std::unique_ptr<node::LineInput> line_input(const node::CardChannel& place) override;
  node::VoltageRange check_output(const node::CardChannel& place) override;
  void check_line_output(const node::CardChannel&) override {}
  void check_line_input(const node::CardChannel&) override {}

  /// Returns the stage of the axis with this name, advanced to the present time.
  Plant& plant(std::string_view axis);

 private:
  struct Stage;
  Stage& stage_driven_by(const node::CardChannel& place);
  void couple(const Config& config);

  unsigned bits_;
  can::Scheduler& scheduler_;
  std::vector<std::unique_ptr<Stage>> stages_;
};

}  // namespace hystcan::twin
