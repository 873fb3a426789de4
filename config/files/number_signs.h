// The decimal sign and the thousands sign of a file, decided once for all of its numbers.
//
//   0,5  12,25  1,5e3     a comma that can only be decimal
//   1.234,5  1.234.567    a point that can only separate thousands
//   1.234                 can be either: the other numbers of the file decide
//
// A number that can be either is decimal if no number says otherwise. Where the file has another decimal
// sign, it is read as thousands only if its column shows that: whole numbers below 1000 stand beside it.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::config {

/// Where a number stands, for a message.
struct NumberPlace {
  std::size_t line = 0, column = 0;  ///< from 1
  std::string text{};
  std::string said() const;  ///< "0,5 (3:1)"
};

struct NumberSigns {
  char decimal = '.';
  char thousands = '\0';
  std::string note{};  ///< what was assumed; empty: the file leaves no choice

  /// A number, also not a finite one; quotes around it are left out. None if it is no number with these
  /// signs.
  std::optional<double> number(std::string_view text) const;
};

/// True if the text is a number with some decimal and thousands sign, or a word like nan.
bool is_number_like(std::string_view text);

/// Takes the numbers of a file and finds its signs.
class SignSurvey {
 public:
  /// `field`: index of the column.
  void add(std::string_view text, std::size_t line, std::size_t column, std::size_t field);
  /// True if a comma or a point that can only be decimal was found.
  bool has_decimal(char sign) const { return sides_[sign == ','].decimal.has_value(); }
  /// What contradicts itself, or can be read in two ways; none if found() is valid.
  std::optional<std::string> contradiction() const;
  NumberSigns found() const;

 private:
  struct Side {
    std::optional<NumberPlace> decimal{}, thousands{}, either{};  ///< the first of each kind
  };
  struct Column {
    bool has_small = false, has_large = false;  ///< whole numbers of up to three digits, or of more
    bool has_either[2] = {false, false};
  };
  bool separates_thousands(std::size_t side) const;

  Side sides_[2];  ///< point, comma
  std::map<std::size_t, Column> columns_;
};

}  // namespace hystcan::config
