// Whether a card has what an axis needs. Each check throws ChannelError.
#pragma once

#include <optional>
#include <string>

#include "node/analogue/card.h"
#include "node/analogue/config.h"

namespace hystcan::node {

/// The range of the output has the volts of each drive.
void check_drives(const AnalogueConfig& config, const DriveRange& drives, const VoltageRange& output);

/// The sensor measures some of the positions that the axis may have, and all setpoints. A reading at an end
/// of the range is no position.
void check_positions(const AnalogueConfig& config, const PositionRange& positions, const VoltageRange& input);

/// The warning that the sensor does not measure the whole stroke; empty: it does.
std::string stroke_warning(const AnalogueConfig& config, const PositionRange& positions,
                           const VoltageRange& input);

/// The card has the channels and lines that the axis drives, and its interlock. Returns the range of the
/// output; drives, sets and locks nothing.
VoltageRange check_channels(const WiredAnalogueAxis& axis, Card& card);

}  // namespace hystcan::node
