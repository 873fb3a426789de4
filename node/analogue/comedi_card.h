// A DAQ card that Linux drives by comedi.
#pragma once

#include <memory>
#include <string>

#include "node/analogue/card.h"

namespace hystcan::node {

/// Throws Error, as open_card does. `file`: "/dev/comedi0".
std::unique_ptr<Card> open_comedi_card(const std::string& file);

}  // namespace hystcan::node
