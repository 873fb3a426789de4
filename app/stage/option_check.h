// Checks of the values that the options of a command take. What they refuse is a usage error, which names the
// option.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::app {

/// Every option with a number has one of these checks: infinities, NaN and numbers with a rest are refused.
CLI::Validator finite_number();
CLI::Validator positive_number();
CLI::Validator not_negative_number();
/// lo <= value <= hi.
CLI::Validator number_between(double lo, double hi);
/// The length of a run: > 0 and < 1e9.
CLI::Validator positive_seconds();
CLI::Validator whole_number(std::uint64_t lo, std::uint64_t hi);

CLI::Validator one_of(const std::vector<std::string>& words);
/// Of those of an enumeration (base/words.h).
CLI::Validator one_of(std::span<const std::string_view> words);

/// The name of a network interface, as Linux takes it.
CLI::Validator interface_name();

/// An option with such a check.
template <class Value>
CLI::Option* add_checked(CLI::App& command, const char* name, Value& value, const CLI::Validator& check,
                         const char* help) {
  return command.add_option(name, value, help)->check(check);
}

}  // namespace hystcan::app
