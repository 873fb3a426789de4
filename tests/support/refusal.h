// Returns the message of a refusal, for tests of invalid input.
#pragma once

#include <string>

#include "base/error.h"

namespace hystcan::support {

/// Returns the message that the attempt throws; "accepted" if it throws nothing. Another exception fails the
/// test.
template <class Refusal = Error, class Attempt>
std::string refusal_of(const Attempt& attempt) {
  try {
    attempt();
  } catch (const Refusal& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace hystcan::support
