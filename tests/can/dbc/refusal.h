// What the reader of DBC files says of a text that it refuses.
#pragma once

#include <string>

#include "can/dbc/database.h"

namespace hystcan::can::dbc_refusal {

inline std::string refusal(const std::string& text) {
  try {
    parse_dbc(text, "lab.dbc");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace hystcan::can::dbc_refusal
