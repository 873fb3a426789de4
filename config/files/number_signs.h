// The decimal sign and the thousands sign of a file, determined once for all of its numbers.
//
//   0,5  12,25  1,5e3     the comma can only be a decimal sign
//   1.234,5  1.234.567    the point can only be a thousands sign
//   1.234                 the point can be either: the other numbers of the file decide
//
// The mark in an ambiguous number is taken as the decimal sign unless other numbers contradict. If other
// numbers show that the file has another decimal sign, the mark is taken as a thousands sign. A column with
// thousands signs has no mark in whole numbers below 1000, and a mark in all larger ones. Therefore, if no
// number such as 1.234.567 proves the thousands sign, the column of each ambiguous number must have whole
// numbers of up to three digits and none with more digits; otherwise the file is refused.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::config {

/// A number in a file and its place, for a message.
struct NumberPlace {
  std::size_t line = 0, column = 0;  ///< place of the number in the file, counted from 1
  std::string text{};
  std::string described() const;  ///< returns number, line and column: "0,5 (3:1)"
};

struct NumberSigns {
  char decimal = '.';
  char thousands = '\0';
  std::string note{};  ///< sentence about the assumption for ambiguous numbers; empty: no assumption

  /// Parses a number, including nan and inf, with or without quotes. Returns nullopt if the text is not a
  /// number with the signs `decimal` and `thousands`.
  std::optional<double> number(std::string_view text) const;
};

/// Returns true if the text is a number with any decimal and thousands sign, or a word such as nan.
bool is_number_like(std::string_view text);

/// Collects the numbers of a file and determines the decimal sign and the thousands sign of the file.
class SignSurvey {
 public:
  /// Adds a number. `line` and `column` are its position in the text; `field` is the index of its field in
  /// the row.
  void add(std::string_view text, std::size_t line, std::size_t column, std::size_t field);
  /// Returns true if `sign`, a point or a comma, occurred in a number in which it can only be a decimal sign.
  bool has_decimal(char sign) const { return sides_[sign == ','].decimal.has_value(); }
  /// Returns a message if the numbers contradict each other or are ambiguous; nullopt if found() is valid.
  std::optional<std::string> contradiction() const;
  NumberSigns found() const;

 private:
  struct Side {
    /// For each meaning of the mark (a point or a comma), the first number that has the mark with this
    /// meaning. `ambiguous`: the mark can be a decimal sign or a thousands sign.
    std::optional<NumberPlace> decimal{}, thousands{}, ambiguous{};
  };
  struct Column {
    /// True if the column has a whole number with up to three digits (small), or with more digits (large).
    /// separates_thousands() uses both.
    bool has_small = false, has_large = false;
    bool has_ambiguous[2] = {false, false};
  };
  bool separates_thousands(std::size_t side) const;

  Side sides_[2];  ///< [0]: numbers with points, [1]: numbers with commas
  std::map<std::size_t, Column> columns_;
};

}  // namespace hystcan::config
