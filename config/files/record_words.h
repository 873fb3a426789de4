// The words of measured records: units, names of columns and settings of instruments. Every reader of a
// record has them from here.
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
  std::string_view base;    ///< "s"; lengths are their own base
  double factor;            ///< of the base
  std::optional<ColumnMeaning> meaning;
  std::string_view others;  ///< other words for it, in lower case, between blanks
};

/// A unit by its symbol or by a word in any case: "ms", "msec", "Millisecond"; both letters for micro are
/// read as u. `nullptr` if the unit is not known.
const UnitWord* find_unit(std::string_view text);
/// True for hh:mm:ss, the form of a time of day in the place of its unit.
bool is_clock_form(std::string_view text);
/// "s, ms, us, ...": the symbols that a column of this meaning can have.
std::string listed_units(ColumnMeaning meaning);

/// How likely a name in lower case has this meaning: 4 for a usual word, 2 if it contains one, else 0.
int name_likeness(std::string_view name, ColumnMeaning meaning);
/// A name for the number of the sample, in lower case: "index".
bool counts_samples(std::string_view name);

enum class RecordSetting { rate_Hz, interval_s, time_unit, value_unit };
struct FoundSetting {
  RecordSetting setting;
  std::size_t length;  ///< of its words
};
/// The setting with which a text in lower case begins; none if it begins with no known one.
std::optional<FoundSetting> find_setting(std::string_view text);

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// Of letters in ASCII.
std::string lower_case(std::string_view text);
/// Both letters that are written for a millionth, in UTF-8 or Latin 1, as u.
std::string with_u(std::string_view text);

}  // namespace hystcan::config
