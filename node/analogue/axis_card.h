// Presents all cards of an axis as one card: a channel may be on another card than `device` of the axis.
#pragma once

#include <memory>
#include <string>

#include "node/analogue/card.h"

namespace hystcan::node {

class Cards;

/// Opens each channel on the card `CardChannel::device`. If this name is empty, the card is the card of the
/// axis.
class AxisCard final : public Card {
 public:
  /// Opens `device`, the card of the axis. Throws ChannelError.
  AxisCard(Cards& cards, const std::string& device);

  std::unique_ptr<VoltageOutput> output(const CardChannel& place) override;
  std::unique_ptr<VoltageInput> input(const CardChannel& place) override;
  std::unique_ptr<LineOutput> line_output(const CardChannel& place) override;
  std::unique_ptr<LineInput> line_input(const CardChannel& place) override;
  VoltageRange check_output(const CardChannel& place) override { return card_at(place).check_output(place); }
  void check_line_output(const CardChannel& place) override { card_at(place).check_line_output(place); }
  void check_line_input(const CardChannel& place) override { card_at(place).check_line_input(place); }

 private:
  Card& card_at(const CardChannel& place);

  Cards& cards_;
  Card& own_;
};

}  // namespace hystcan::node
