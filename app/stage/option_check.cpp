#include "app/stage/option_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/text.h"
#include "can/bus.h"

namespace hystcan::app {
namespace {

/// Returns a check that accepts a text if `is_sound` is true. `expected`: valid values, for the error
/// message. `type`: addition to the option's type in the help.
CLI::Validator expecting(std::string expected, auto is_sound, const char* type = "") {
  return {[expected = std::move(expected), is_sound](const std::string& text) {
            return is_sound(text) ? std::string() : fmt::format("{}, expected {}", text, expected);
          },
          type};
}

CLI::Validator number_that(std::string expected, auto is_in_range, const char* type = "") {
  return expecting(
      std::move(expected),
      [is_in_range](const std::string& text) {
        const auto value = parsed_number<double>(text);
        return value && std::isfinite(*value) && is_in_range(*value);
      },
      type);
}

}  // namespace

CLI::Validator finite_number() {
  return number_that("a finite number", [](double) { return true; });
}

CLI::Validator positive_number() {
  return number_that("a finite number > 0", [](double value) { return value > 0.0; });
}

CLI::Validator not_negative_number() {
  return number_that("a finite number >= 0", [](double value) { return value >= 0.0; });
}

CLI::Validator number_between(double lo, double hi) {
  return number_that(fmt::format("a number from {} to {}", lo, hi),
                     [lo, hi](double value) { return value >= lo && value <= hi; });
}

CLI::Validator positive_seconds() {
  return number_that(
      "seconds > 0 and < 1e9", [](double value) { return value > 0.0 && value < 1e9; }, "SECONDS");
}

CLI::Validator whole_number(std::uint64_t lo, std::uint64_t hi) {
  return expecting(fmt::format("a whole number from {} to {}", lo, hi), [lo, hi](const std::string& text) {
    const auto value = parsed_number<std::uint64_t>(text);
    return value && *value >= lo && *value <= hi;
  });
}

CLI::Validator one_of(const std::vector<std::string>& words) {
  CLI::Validator check =
      expecting(fmt::format("one of {}", fmt::join(words, ", ")),
                [words](const std::string& text) { return std::ranges::find(words, text) != words.end(); });
  return check.description(fmt::format("{{{}}}", fmt::join(words, ",")));
}

CLI::Validator one_of(std::span<const std::string_view> words) {
  return one_of(std::vector<std::string>(words.begin(), words.end()));
}

CLI::Validator interface_name() {
  return expecting(std::string(can::expected_interface_name),
                   [](const std::string& text) { return can::is_interface_name(text); });
}

}  // namespace hystcan::app
