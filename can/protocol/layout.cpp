#include "can/protocol/layout.h"

#include <cmath>
#include <cstdlib>

namespace hystcan::can {
namespace {

// The prefix "micro" is the letter u, or the micro sign: U+00B5 or U+03BC in UTF-8, or 0xB5 in Latin-1.
using Prefix = std::pair<std::string_view, int>;  ///< the letters of a prefix, and its power of ten
constexpr std::array prefixes{Prefix{"p", -12},       Prefix{"n", -9},        Prefix{"u", -6},
                              Prefix{"\xC2\xB5", -6}, Prefix{"\xCE\xBC", -6}, Prefix{"\xB5", -6},
                              Prefix{"m", -3},        Prefix{"k", 3},         Prefix{"M", 6}};

constexpr std::array<std::string_view, 5> base_units{"V", "A", "m", "Hz", "s"};

/// Splits a unit into its base unit and the power of ten of its prefix: mV gives V and -3.
std::optional<std::pair<std::string_view, int>> parse(std::string_view unit) {
  for (const std::string_view base : base_units) {
    if (!unit.ends_with(base)) continue;
    const std::string_view before = unit.substr(0, unit.size() - base.size());
    if (before.empty()) return std::pair(base, 0);
    for (const auto& [letters, exponent] : prefixes)
      if (before == letters) return std::pair(base, exponent);
  }
  return std::nullopt;
}

}  // namespace

const Signal& find_signal(const Message& message, const std::string& name) {
  const Signal* const found = message.find(name);
  if (found == nullptr) throw std::invalid_argument("message " + message.name + " has no signal " + name);
  if (message.length > Frame{}.data.size() || bytes_needed(*found) > message.length)
    throw std::invalid_argument("signal " + name + " lies outside message " + message.name);
  return *found;
}

Protection protection_of(const Message& message, const MessageMap& map) {
  Protection protection{.polynomial = map.polynomial, .data_id = map.data_id};
  if (map.integrity == Integrity::none) return protection;
  protection.counter.emplace(find_signal(message, map.counter));
  if (map.integrity == Integrity::counter) return protection;
  const Signal& crc = find_signal(message, map.crc);
  protection.crc.emplace(crc);
  if (!protection.crc->fills_bytes(bytes_of(map.polynomial)))
    throw std::invalid_argument("signal " + map.crc + " of message " + message.name + " does not fill " +
                                std::to_string(bytes_of(map.polynomial)) + " bytes");
  return protection;
}

AmpState StateValues::state(std::int64_t raw) const {
  const auto lists = {std::pair(&fault, AmpState::fault), std::pair(&enabled, AmpState::enabled),
                      std::pair(&ready, AmpState::ready)};
  for (const auto& [values, state] : lists)
    if (std::ranges::find(*values, raw) != values->end()) return state;
  return AmpState::off;
}

std::int64_t StateValues::raw(AmpState state) const {
  const std::array lists{&off, &ready, &enabled, &fault};
  for (const auto* values : {lists[static_cast<std::size_t>(state)], &off})
    if (!values->empty()) return values->front();
  return 0;
}

const Message& find_message(const Database& database, const MessageMap& map) {
  if (const Message* found = database.find(map.message)) return *found;
  throw std::invalid_argument("no message " + map.message);
}

std::optional<DecimalStep> decimal_step(std::string_view theirs, std::string_view ours) {
  DecimalStep step;
  if (theirs == ours) return step;
  const auto from = parse(theirs);
  const auto to = parse(ours);
  if (!from || !to || from->first != to->first) return std::nullopt;
  const int exponent = from->second - to->second;
  (exponent >= 0 ? step.multiplier_ : step.divisor_) = std::pow(10.0, std::abs(exponent));
  return step;
}

}  // namespace hystcan::can
