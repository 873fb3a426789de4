// Checks that a card has everything that an axis needs. Each check throws ChannelError.
#pragma once

#include <optional>
#include <string>

#include "node/analogue/card.h"
#include "node/analogue/config.h"

namespace hystcan::node {

/// Checks that the range of the output contains the voltages of the minimum, maximum and safe drive.
void check_drives(const AnalogueConfig& config, const DriveRange& drives, const VoltageRange& output);

/// Checks that the sensor can measure all setpoints and at least some of the positions allowed for the axis.
/// A reading at an end of the input range is not a position, because it may be clipped.
void check_positions(const AnalogueConfig& config, const PositionRange& positions, const VoltageRange& input);

/// Returns a warning if the sensor does not measure the whole stroke; otherwise an empty text.
std::string stroke_warning(const AnalogueConfig& config, const PositionRange& positions,
                           const VoltageRange& input);

/// Checks that the card has all channels and lines of the axis, including the interlock. Returns the range of
/// the output. Drives no output, sets no line and locks nothing.
VoltageRange check_channels(const WiredAnalogueAxis& axis, Card& card);

}  // namespace hystcan::node
