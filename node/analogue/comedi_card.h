// A DAQ card that Linux drives through comedi.
#pragma once

#include <memory>
#include <string>

#include "node/analogue/card.h"

namespace hystcan::node {

/// Opens a card, for example `file` = "/dev/comedi0". Throws Error, as open_card() does.
std::unique_ptr<Card> open_comedi_card(const std::string& file);

}  // namespace hystcan::node
