#include "app/live/card_opener.h"

#include <memory>
#include <string>

#include "node/analogue/device_name.h"
#include "twin/simulated_card.h"

namespace hystcan::app {

node::Cards::Open card_opener(const config::Config& config, const std::vector<node::WiredAnalogueAxis>& axes,
                              can::Scheduler& scheduler) {
  return [&](const std::string& device) -> std::unique_ptr<node::Card> {
    if (node::device_named(device).kind != node::CardKind::simulated) return node::open_card(device);
    return std::make_unique<twin::SimulatedCard>(device, twin_config(config), axes, scheduler);
  };
}

}  // namespace hystcan::app
