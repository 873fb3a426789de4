// Reads a saved memory as any other program would, and compares memories to the bit.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "model/memory.h"
#include "model/prandtl_ishlinskii.h"

namespace hystcan::model {

inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

inline bool same_bits(const HysteresisState& a, const HysteresisState& b) {
  bool same = a.depth() == b.depth() && a.origin == b.origin && a.merged == b.merged &&
              same_bits(a.input, b.input) && same_bits(a.output, b.output);
  for (std::size_t i = 0; same && i < a.depth(); ++i) {
    const Branch &p = a.branches[i], &q = b.branches[i];
    same = same_bits(p.start_input, q.start_input) && same_bits(p.start_level, q.start_level) &&
           same_bits(p.offset, q.offset) && same_bits(p.coefficient, q.coefficient) &&
           p.increasing == q.increasing;
  }
  return same;
}

inline bool same_bits(const PlayState& a, const PlayState& b) {
  return same_bits(a.input, b.input) && same_bits(a.output, b.output) &&
         std::ranges::equal(a.plays, b.plays, [](double x, double y) { return same_bits(x, y); });
}

/// Returns the text after `key = `; empty if there is no such line.
inline std::string value_of(const std::string& text, const std::string& key) {
  const auto start = text.find("\n" + key + " = ");
  if (start == std::string::npos) return "";
  const auto from = start + key.size() + 4;
  return text.substr(from, text.find('\n', from) - from);
}

inline double number_of(const std::string& text, const std::string& key) {
  return std::strtod(value_of(text, key).c_str(), nullptr);
}

inline std::vector<double> numbers_of(const std::string& text, const std::string& key) {
  const std::string list = value_of(text, key);
  std::vector<double> numbers;
  for (const char* at = list.c_str() + 1; *at != ']' && *at != '\0';) {
    char* end = nullptr;
    numbers.push_back(std::strtod(at, &end));
    at = *end == ',' ? end + 1 : end;
  }
  return numbers;
}

}  // namespace hystcan::model
