// The nodes of axes whose amplifiers and sensors are connected to cards.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "node/amplifier_channel.h"
#include "node/analogue/axis_card.h"
#include "node/analogue/axis_check.h"
#include "node/analogue/card_input.h"
#include "node/analogue/card_output.h"
#include "node/sensor_channel.h"
#include "node/shared_connection.h"
#include "node/station.h"

namespace hystcan::node {

/// The open cards. Axes that share a card get the same object, even if they use different names for the card.
class Cards {
 public:
  /// `open` opens a card by its name, as open_card() does.
  using Open = std::function<std::unique_ptr<Card>(const std::string& device)>;
  explicit Cards(Open open) : open_(std::move(open)) {}

  /// Returns the card with this name, and opens the card at first use. Throws ChannelError.
  Card& card(const std::string& device);

 private:
  Open open_;
  std::map<std::string, std::unique_ptr<Card>, std::less<>> cards_;  ///< the open cards; key: identity_of()
};

/// The devices of one axis. Throws ChannelError if the card lacks a channel of the axis.
struct AnalogueDevices {
  AnalogueDevices(const WiredAnalogueAxis& wired, Cards& cards)
      : axis(wired),
        card(cards, axis.config.device),
        output(axis.config, axis.drives, card),
        input(axis.config, card) {
    check_positions(axis.config, axis.positions, input.range());
  }
  AnalogueDevices(const AnalogueDevices&) = delete;
  AnalogueDevices& operator=(const AnalogueDevices&) = delete;

  WiredAnalogueAxis axis;
  AxisCard card;
  CardOutput output;
  CardInput input;
};
using AllDevices = std::vector<std::unique_ptr<AnalogueDevices>>;

/// The amplifier channel and the sensor channel of one axis.
struct AnalogueAxis {
  AnalogueAxis(AnalogueDevices& devices, const CommonConfig& common, const can::Database& database,
               can::Scheduler& scheduler, AmplifierNode& amplifier_node, SensorNode& sensor_node);
  AnalogueAxis(const AnalogueAxis&) = delete;
  AnalogueAxis& operator=(const AnalogueAxis&) = delete;

  can::AxisWire wire;
  AmplifierChannel amplifier;
  SensorChannel sensor;
};

// At a SYNC the amplifier nodes apply the last setpoints, then the sensor nodes sample, then samples and
// statuses are sent.

class AnalogueStation {
 public:
  /// Axes with the same node number share one node.
  AnalogueStation(const AllDevices& devices, const CommonConfig& common, const can::Database& database,
                  can::Scheduler& scheduler, const can::Attach& attach);

  Station& station() { return station_; }
  const Station& station() const { return station_; }
  const std::vector<std::unique_ptr<AnalogueAxis>>& axes() const { return axes_; }

 private:
  SharedConnection connection_;
  Station station_;
  std::vector<std::unique_ptr<AnalogueAxis>> axes_;
};

}  // namespace hystcan::node
