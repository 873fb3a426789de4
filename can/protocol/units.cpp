#include "can/protocol/units.h"

#include <array>
#include <cmath>
#include <cstdlib>

namespace hystcan::can {
namespace {

struct Prefix {
  std::string_view letters;
  int exponent;
};

// A micro sign is U+00B5 or U+03BC in UTF-8. The DBC reader converts Latin-1 to UTF-8.
constexpr std::array<Prefix, 9> prefixes{{{"p", -12},
                                          {"n", -9},
                                          {"u", -6},
                                          {"\xC2\xB5", -6},
                                          {"\xCE\xBC", -6},
                                          {"\xB5", -6},
                                          {"m", -3},
                                          {"k", 3},
                                          {"M", 6}}};

constexpr std::array<std::string_view, 3> base_units{"V", "A", "m"};

struct Scaled {
  std::string_view base;
  int exponent = 0;
};

std::optional<Scaled> parse(std::string_view unit) {
  for (const std::string_view base : base_units) {
    if (!unit.ends_with(base)) continue;
    const std::string_view before = unit.substr(0, unit.size() - base.size());
    if (before.empty()) return Scaled{base, 0};
    for (const Prefix& prefix : prefixes)
      if (before == prefix.letters) return Scaled{base, prefix.exponent};
  }
  return std::nullopt;
}

}  // namespace

std::optional<DecimalStep> decimal_step(std::string_view theirs, std::string_view ours) {
  DecimalStep step;
  if (theirs == ours) return step;
  const auto from = parse(theirs);
  const auto to = parse(ours);
  if (!from || !to || from->base != to->base) return std::nullopt;
  const int exponent = from->exponent - to->exponent;
  (exponent >= 0 ? step.multiplier_ : step.divisor_) = std::pow(10.0, std::abs(exponent));
  return step;
}

}  // namespace hystcan::can
