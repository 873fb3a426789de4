// Checks for the values of command-line options. An invalid value is a usage error that names the option.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::app {

/// The following checks are used for all options with a number. They refuse infinity, NaN, and numbers that
/// are followed by other text.
CLI::Validator finite_number();
CLI::Validator positive_number();
CLI::Validator not_negative_number();
/// Accepts a number from `lo` to `hi`, including both.
CLI::Validator number_between(double lo, double hi);
/// Accepts a duration in s that is positive and less than 1e9.
CLI::Validator positive_seconds();
CLI::Validator whole_number(std::uint64_t lo, std::uint64_t hi);

CLI::Validator one_of(const std::vector<std::string>& words);
/// Accepts one of `words`, which are the words of an enumeration (base/words.h).
CLI::Validator one_of(std::span<const std::string_view> words);

/// Accepts a valid name of a Linux network interface.
CLI::Validator interface_name();

/// Adds an option with one of the checks above.
template <class Value>
CLI::Option* add_checked(CLI::App& command, const char* name, Value& value, const CLI::Validator& check,
                         const char* help) {
  return command.add_option(name, value, help)->check(check);
}

}  // namespace hystcan::app
