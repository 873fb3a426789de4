// The known words in measured records: units, column names and instrument settings. All readers of records
// use these lists.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::config {

enum class ColumnMeaning : std::size_t { time, input, output };

inline constexpr std::array<std::string_view, 3> column_meanings{"time", "input", "output"};

struct UnitWord {
  std::string_view symbol;  ///< symbol of the unit: "ms"
  std::string_view base;    ///< unit to which values are converted: "s" for "ms", "V" for "kV"
  double factor;            ///< size of the unit in base units: 1e-3 for "ms"
  std::optional<ColumnMeaning> meaning;
  std::string_view others;  ///< other spellings of the unit, in lower case, separated by blanks
};

/// Finds a unit by its symbol, or by a word in upper or lower case: "ms", "msec", "Millisecond". The micro
/// sign is the same as u. Returns `nullptr` if the unit is unknown.
const UnitWord* find_unit(std::string_view text);
/// Returns true for a text such as hh:mm:ss, which a column with times of day has in place of a unit.
bool is_clock_form(std::string_view text);
/// Returns the symbols of all units that a column of this meaning can have: "s, ms, us, ...".
std::string listed_units(ColumnMeaning meaning);

/// Returns a score of how likely a column with this name has this meaning: 4 if the name is a usual word for
/// the meaning, 2 if the name contains such a word, else 0. The name must be in lower case.
int name_likeness(std::string_view name, ColumnMeaning meaning);
/// Returns true if the name is a usual name of the sample number, such as "index". The name must be in lower
/// case.
bool counts_samples(std::string_view name);

enum class RecordSetting { rate_Hz, interval_s, time_unit, value_unit };
struct FoundSetting {
  RecordSetting setting;
  std::size_t length;  ///< number of characters in the words that name the setting
};
/// Returns the instrument setting with whose name the text begins; nullopt if the text begins with none. The
/// text must be in lower case.
std::optional<FoundSetting> find_setting(std::string_view text);

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// Returns the text with its ASCII letters in lower case.
std::string lower_case(std::string_view text);
/// Returns the text with each micro sign replaced by u (both UTF-8 characters and the one of Latin 1).
std::string with_u(std::string_view text);

}  // namespace hystcan::config
