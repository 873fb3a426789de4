#include "node/analogue/axis_card.h"

#include "node/analogue/analogue_station.h"

namespace hystcan::node {

AxisCard::AxisCard(Cards& cards, const std::string& device) : cards_(cards), own_(cards.card(device)) {}

Card& AxisCard::card_at(const CardChannel& place) {
  return place.device.empty() ? own_ : cards_.card(place.device);
}

std::unique_ptr<VoltageOutput> AxisCard::output(const CardChannel& place) {
  return card_at(place).output(place);
}
std::unique_ptr<VoltageInput> AxisCard::input(const CardChannel& place) {
  return card_at(place).input(place);
}
std::unique_ptr<LineOutput> AxisCard::line_output(const CardChannel& place) {
  return card_at(place).line_output(place);
}
std::unique_ptr<LineInput> AxisCard::line_input(const CardChannel& place) {
  return card_at(place).line_input(place);
}

}  // namespace hystcan::node
