// A converter chip that Linux drives through IIO, such as those on a Raspberry Pi HAT.
#pragma once

#include <memory>
#include <string>

#include "node/analogue/card.h"

namespace hystcan::node {

// A channel has attributes in sysfs; its range follows from the attributes that the chip's driver provides:
//
//   volts = scale * (raw + offset) / 1000
//   raw   its range is the attribute `raw_available`, or follows from the number of bits; if the driver
//         provides neither, the key `range` of the configuration gives the range of the volts
//
// The key `range` selects one of the values of the attributes `scale_available` and `offset_available`. The
// value `volts` is the voltage at the chip: it does not include a divider or an amplifier outside the chip.
//
// IIO has no digital lines.

/// Opens a card. `name`: name, label or id of the device, such as "ad5791" or "iio:device0". Throws Error, as
/// open_card() does.
std::unique_ptr<Card> open_iio_card(const std::string& name);

}  // namespace hystcan::node
