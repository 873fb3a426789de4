// The decimal sign and the thousands sign of a file, determined once for all of its numbers.
//
//   0,5  12,25  1,5e3     a comma that can only be decimal
//   1.234,5  1.234.567    a point that can only separate thousands
//   1.234                 can be either: the other numbers of the file decide
//
// An ambiguous number is read as decimal unless other numbers contradict it. If the file has another decimal
// sign, the ambiguous mark counts as a thousands sign only if its column also has whole numbers below 1000.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::config {

/// The place of a number, for a message.
struct NumberPlace {
  std::size_t line = 0, column = 0;  ///< counted from 1
  std::string text{};
  std::string described() const;  ///< "0,5 (3:1)"
};

struct NumberSigns {
  char decimal = '.';
  char thousands = '\0';
  std::string note{};  ///< the assumption, if the numbers of the file are ambiguous; else empty

  /// Parses a number, including nan and inf, with or without quotes. nullopt if it is not a number with these
  /// signs.
  std::optional<double> number(std::string_view text) const;
};

/// Returns true for a number with some decimal and thousands sign, and for a word like nan.
bool is_number_like(std::string_view text);

/// Collects the numbers of a file and determines its signs.
class SignSurvey {
 public:
  /// `field`: index of the column.
  void add(std::string_view text, std::size_t line, std::size_t column, std::size_t field);
  /// Returns true if this sign occurred where it can only be decimal.
  bool has_decimal(char sign) const { return sides_[sign == ','].decimal.has_value(); }
  /// Returns a contradiction or an ambiguity; nullopt if found() is valid.
  std::optional<std::string> contradiction() const;
  NumberSigns found() const;

 private:
  struct Side {
    std::optional<NumberPlace> decimal{}, thousands{}, ambiguous{};  ///< the first number of each kind
  };
  struct Column {
    bool has_small = false, has_large = false;  ///< a whole number of up to three digits, of more digits
    bool has_ambiguous[2] = {false, false};
  };
  bool separates_thousands(std::size_t side) const;

  Side sides_[2];  ///< the numbers with points, and those with commas
  std::map<std::size_t, Column> columns_;
};

}  // namespace hystcan::config
