// Conditions that a fuzz target checks: the program aborts if one does not hold, which the fuzzer reports.
#pragma once

#include <cstdlib>
#include <string_view>

namespace hystcan::fuzz {

inline void demand(bool condition) {
  if (!condition) std::abort();
}

/// A message about refused input must state what is expected or what is not allowed.
inline void demand_advice(std::string_view message) {
  demand(message.find("expected ") != std::string_view::npos ||
         message.find(" is not allowed") != std::string_view::npos);
}

}  // namespace hystcan::fuzz
