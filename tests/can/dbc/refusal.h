// Returns the message of the DBC reader about a refused text.
#pragma once

#include <string>

#include "can/dbc/database.h"
#include "tests/support/refusal.h"

namespace hystcan::can::dbc_refusal {

inline std::string refusal(const std::string& text) {
  return support::refusal_of([&] { parse_dbc(text, "lab.dbc"); });
}

}  // namespace hystcan::can::dbc_refusal
