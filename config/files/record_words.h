// The words of measured records: units, column names and instrument settings. All readers of records use this
// list.
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
  std::string_view symbol;  ///< "ms"
  std::string_view base;    ///< "s"; each unit of length is its own base
  double factor;            ///< size of the unit in the base unit
  std::optional<ColumnMeaning> meaning;
  std::string_view others;  ///< other spellings, in lower case, separated by blanks
};

/// Finds a unit by its symbol or by a word in any case: "ms", "msec", "Millisecond"; both micro signs count
/// as u. `nullptr` if the unit is not known.
const UnitWord* find_unit(std::string_view text);
/// Returns true for hh:mm:ss, which a time of day has instead of a unit.
bool is_clock_form(std::string_view text);
/// Returns "s, ms, us, ...": the allowed symbols for a column of this meaning.
std::string listed_units(ColumnMeaning meaning);

/// Returns how likely a name in lower case has this meaning: 4 for a usual word, 2 if it contains one, else
/// 0.
int name_likeness(std::string_view name, ColumnMeaning meaning);
/// Returns true for a name of the sample number, in lower case: "index".
bool counts_samples(std::string_view name);

enum class RecordSetting { rate_Hz, interval_s, time_unit, value_unit };
struct FoundSetting {
  RecordSetting setting;
  std::size_t length;  ///< number of characters of the setting's words
};
/// Finds the setting at the beginning of a text in lower case; nullopt if it begins with none.
std::optional<FoundSetting> find_setting(std::string_view text);

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// Converts ASCII letters to lower case.
std::string lower_case(std::string_view text);
/// Replaces both micro signs, in UTF-8 or Latin 1, by u.
std::string with_u(std::string_view text);

}  // namespace hystcan::config
