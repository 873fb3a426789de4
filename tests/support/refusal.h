// The message of a refusal, for tests of what is refused.
#pragma once

#include <string>

#include "base/error.h"

namespace hystcan::support {

/// What the attempt throws says; "accepted" if it throws nothing. Another exception fails the test.
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
