// A converter chip that Linux drives by IIO, such as those of a Raspberry Pi's HAT.
#pragma once

#include <memory>
#include <string>

#include "node/analogue/card.h"

namespace hystcan::node {

// A channel has attributes in sysfs; the range follows from those that the chip's driver has:
//
//   volts = scale * (raw + offset) / 1000
//   raw   from `raw_available` or from the bits of a sample; else the volts are those of `range`
//
// `range` chooses among `scale_available` and `offset_available`. Volts are those at the chip.
//
// IIO has no digital lines.

/// Throws Error, as open_card does. `name`: name, label or id of the device: "ad5791", "iio:device0".
std::unique_ptr<Card> open_iio_card(const std::string& name);

}  // namespace hystcan::node
