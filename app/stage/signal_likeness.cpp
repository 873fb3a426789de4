#include "app/stage/signal_likeness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "can/protocol/layout.h"

namespace hystcan::app {
namespace {

using can::Message;
using can::Signal;

/// The parts of AmpSetpoint_V1 are amp, setpoint, v, 1.
std::vector<std::string> parts(std::string_view name) {
  std::vector<std::string> found;
  char before = '_';
  for (const char c : name) {
    const auto is = [](int (*of)(int), char what) { return of(static_cast<unsigned char>(what)) != 0; };
    const bool begins = (is(std::isupper, c) && !is(std::isupper, before)) ||
                        is(std::isdigit, c) != is(std::isdigit, before) || !is(std::isalnum, before);
    if (is(std::isalnum, c)) {
      if (begins || found.empty()) found.emplace_back();
      found.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    before = c;
  }
  return found;
}

/// Points for the range that the DBC states, if it states one.
int points_of_range(const Signal& signal, std::string_view unit, const model::Interval& values) {
  if (!(signal.minimum < signal.maximum)) return 0;
  const auto step = can::decimal_step(signal.unit, unit);
  const bool holds = step->to_ours(signal.minimum) <= values.lo && step->to_ours(signal.maximum) >= values.hi;
  return holds ? 1 : -4;
}

}  // namespace

std::string in_lower_case(std::string_view text) {
  std::string low(text);
  std::ranges::transform(low, low.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return low;
}

std::string_view word_in(std::string_view name, const Words& words) {
  const std::vector<std::string> found = parts(name);
  for (const std::string_view word : words)
    for (const std::string& part : found)
      if (part == word || (word.size() > 2 && part.starts_with(word))) return word;
  return {};
}

bool converts(const Signal& signal, std::string_view unit) {
  return !signal.unit.empty() && can::is_decodable(signal) &&
         can::decimal_step(signal.unit, unit).has_value();
}

LikeSignal LikeSignals::best(std::string_view unit, const model::Interval& values, const Words& words,
                             const Words& others, const Words& names) const {
  LikeSignal best;
  for (const Message& message : database_.messages) {
    if (taken_.contains(&message)) continue;
    for (const Signal& signal : message.signals) {
      if (!converts(signal, unit) || signal.multiplexing.present_at) continue;
      LikeSignal one = judged(message, signal, words, others, names);
      one.points += points_of_range(signal, unit, values);
      if (one.points > best.points) best = std::move(one);
    }
  }
  return best;
}

LikeSignal LikeSignals::judged(const Message& message, const Signal& signal, const Words& words,
                               const Words& others, const Words& names) const {
  LikeSignal one{&message, &signal, 1, signal.unit};
  const auto count = [&](std::string_view name, const Words& of, int points) {
    const std::string_view word = word_in(name, of);
    if (word.empty()) return;
    one.points += points;
    if (points > 0 && one.because.find(word) == std::string::npos) one.because += fmt::format(", {}", word);
  };
  count(signal.name, words, 3);
  count(message.name, words, 2);
  count(signal.name, others, -3);
  count(message.name, others, -2);
  count(signal.name, names, 1);
  if (!axis_.empty() && is_of_axis(message, signal)) {
    one.points += 6;
    one.because += fmt::format(", {}", axis_);
  }
  return one;
}

bool LikeSignals::is_of_axis(const Message& message, const Signal& signal) const {
  for (const std::string& name : {message.name, signal.name, message.sender}) {
    const std::vector<std::string> found = parts(name);
    if (std::ranges::find(found, axis_) != found.end() || in_lower_case(name).starts_with(axis_ + "amp") ||
        in_lower_case(name).starts_with(axis_ + "sens"))
      return true;
  }
  return false;
}

}  // namespace hystcan::app
