// The position that a card's converter reads from a sensor.
#pragma once

#include <memory>

#include "node/analogue/card.h"
#include "node/analogue/config.h"
#include "node/position_input.h"

namespace hystcan::node {

//   position = position_zero_um + position_um_per_V * volts
//
// `volts` is the mean of `average` conversions.
//
// A reading within one step of an end of the range may be clipped. Such a reading, or a failed conversion,
// has no position and reports this in its status: an old or wrong position never counts as good.

class CardInput final : public PositionInput {
 public:
  /// Throws ChannelError if the card lacks the channel.
  CardInput(const AnalogueConfig& config, Card& card);

  Reading read(can::Time at) override;
  const VoltageRange& range() const { return input_->range(); }

 private:
  double um_per_V_;
  double zero_um_;
  unsigned average_;
  std::unique_ptr<VoltageInput> input_;
};

}  // namespace hystcan::node
