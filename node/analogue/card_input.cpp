#include "node/analogue/card_input.h"

namespace hystcan::node {

CardInput::CardInput(const AnalogueConfig& config, Card& card)
    : um_per_V_(config.position_um_per_V),
      zero_um_(config.position_zero_um),
      average_(config.position_input.average),
      input_(opened("position_input", [&] { return card.input(config.position_input.place); })) {}

PositionInput::Reading CardInput::read(can::Time) {
  const VoltageRange& range = input_->range();
  Reading reading;
  double sum_V = 0.0;
  for (unsigned i = 0; i < average_; ++i) {
    const std::optional<double> volts = input_->read();
    if (!volts) return {.position_um = zero_um_, .status = sensor_status::no_position};
    if (*volts < range.lo + range.step || *volts > range.hi - range.step)
      reading.status = sensor_status::out_of_range | sensor_status::no_position;
    sum_V += *volts;
  }
  reading.position_um = zero_um_ + um_per_V_ * sum_V / average_;
  return reading;
}

}  // namespace hystcan::node
