#include "config/files/number_signs.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "config/files/csv.h"
#include "config/files/record_words.h"

namespace hystcan::config {
namespace {

constexpr char signs[2] = {'.', ','};

/// A number in text form, split into sign, digits and exponent.
struct Parts {
  bool is_negative = false;
  std::string digits{};  ///< the digits with their points and commas
  std::string_view exponent{};
};

/// Returns the length in bytes of an apostrophe or a blank (ASCII or Unicode) at the beginning of the text,
/// if a group of exactly three digits follows; otherwise 0.
std::size_t length_of_mark(std::string_view text) {
  for (const std::string_view mark : {"'", " ", "\xE2\x80\x99", "\xC2\xA0", "\xE2\x80\xAF", "\xE2\x80\x89"}) {
    if (!text.starts_with(mark)) continue;
    const std::string_view group = text.substr(mark.size());
    const bool is_group = group.size() >= 3 && std::all_of(group.begin(), group.begin() + 3, is_digit) &&
                          (group.size() == 3 || !is_digit(group[3]));
    return is_group ? mark.size() : 0;
  }
  return 0;
}

/// Returns true if the text has an apostrophe, a blank or a non-ASCII character. Such a number needs
/// parts_of().
bool has_other_marks(std::string_view text) {
  return std::ranges::any_of(
      text, [](char c) { return c == '\'' || c == ' ' || static_cast<unsigned char>(c) >= 0x80; });
}

/// Splits a number into its parts. Drops apostrophes and blanks between groups of digits, and accepts a
/// typographic minus sign: these characters are unambiguous. Returns nullopt if the text is not a number.
std::optional<Parts> parts_of(std::string_view text) {
  text = unquoted(text);
  Parts parts;
  if (text.starts_with('+') || text.starts_with('-')) {
    parts.is_negative = text.front() == '-';
    text.remove_prefix(1);
  } else if (text.starts_with("\xE2\x88\x92")) {
    parts.is_negative = true;
    text.remove_prefix(3);
  }
  std::size_t i = 0;
  while (i < text.size()) {
    if (is_digit(text[i]) || text[i] == '.' || text[i] == ',')
      parts.digits += text[i++];
    else if (const std::size_t mark = length_of_mark(text.substr(i));
             mark > 0 && i > 0 && is_digit(text[i - 1]))
      i += mark;
    else
      break;
  }
  if (parts.digits.find_first_of("0123456789") == std::string::npos || parts.digits.back() == ',')
    return std::nullopt;
  text.remove_prefix(i);
  if (text.empty()) return parts;
  if (text.front() != 'e' && text.front() != 'E') return std::nullopt;
  parts.exponent = text;
  text.remove_prefix(1);
  if (text.starts_with('+') || text.starts_with('-')) text.remove_prefix(1);
  if (text.empty() || !std::ranges::all_of(text, is_digit)) return std::nullopt;
  return parts;
}

/// Returns true if `sign` separates groups of three digits, as the point in 1.234.567.
bool is_grouped(std::string_view digits, char sign) {
  const std::size_t first = digits.find(sign);
  if (first == 0 || first > 3 || digits.front() == '0') return false;
  for (std::size_t at = first; at != std::string_view::npos;) {
    const std::size_t next = digits.find(sign, at + 1);
    const std::string_view group =
        digits.substr(at + 1, next == std::string_view::npos ? next : next - at - 1);
    if (group.size() != 3 || !std::ranges::all_of(group, is_digit)) return false;
    at = next;
  }
  return true;
}

/// What one number shows about its file: the mark that is the decimal sign, the mark that is the thousands
/// sign, and the mark that can be both.
struct Evidence {
  bool is_number = false;
  std::optional<char> decimal{}, thousands{}, ambiguous{};
};

Evidence evidence_of(const Parts& parts) {
  const std::string_view digits = parts.digits;
  const auto points = std::ranges::count(digits, '.'), commas = std::ranges::count(digits, ',');
  if (points == 0 && commas == 0) return {.is_number = true};
  if (points > 0 && commas > 0) {
    const char last = digits[digits.find_last_of(".,")], other = last == '.' ? ',' : '.';
    const bool fits = std::min(points, commas) >= 1 && (last == '.' ? points : commas) == 1 &&
                      is_grouped(digits.substr(0, digits.rfind(last)), other);
    if (!fits) return {};
    return {.is_number = true, .decimal = last, .thousands = other};
  }
  const char sign = points > 0 ? '.' : ',';
  const bool grouped = parts.exponent.empty() && is_grouped(digits, sign);
  if (points + commas > 1) return {.is_number = grouped, .thousands = sign};
  if (grouped) return {.is_number = true, .ambiguous = sign};
  return {.is_number = true, .decimal = sign};
}

void keep_first(std::optional<NumberPlace>& kept, const NumberPlace& place) {
  if (!kept) kept = place;
}

}  // namespace

std::string NumberPlace::described() const { return fmt::format("{} ({}:{})", text, line, column); }

std::optional<double> NumberSigns::number(std::string_view text) const {
  text = unquoted(text);
  if (decimal == '.' && thousands == '\0') {
    if (const auto value = parsed_number<double>(text)) return value;
    if (!has_other_marks(text)) return std::nullopt;
  }
  char buffer[64];
  if (decimal == ',' && thousands == '\0' && text.size() <= sizeof buffer && !has_other_marks(text)) {
    if (text.find('.') != std::string_view::npos) return std::nullopt;
    std::ranges::replace_copy(text, buffer, ',', '.');
    return parsed_number<double>({buffer, text.size()});
  }
  const std::optional<Parts> parts = parts_of(text);
  if (!parts) return parsed_number<double>(text);  // a word such as nan or inf
  const Evidence evidence = evidence_of(*parts);
  if (!evidence.is_number) return std::nullopt;
  std::string plain = parts->is_negative ? "-" : "";
  for (const char c : parts->digits) {
    if (is_digit(c))
      plain += c;
    else if (c == decimal)
      plain += '.';
    else if (c != thousands)
      return std::nullopt;
  }
  // Refuses a number whose own marks show other signs than `decimal` and `thousands`.
  if (evidence.thousands && *evidence.thousands != thousands) return std::nullopt;
  if (evidence.decimal && *evidence.decimal != decimal) return std::nullopt;
  return parsed_number<double>(plain.append(parts->exponent));
}

bool is_number_like(std::string_view text) {
  text = unquoted(text);
  if (text.empty()) return false;
  if (const auto parts = parts_of(text)) return evidence_of(*parts).is_number;
  return parsed_number<double>(text).has_value();
}

void SignSurvey::add(std::string_view text, std::size_t line, std::size_t column, std::size_t field) {
  const std::optional<Parts> parts = parts_of(text);
  if (!parts) return;
  const Evidence evidence = evidence_of(*parts);
  if (!evidence.is_number) return;
  Column& of = columns_[field];
  if (parts->digits.find_first_of(".,") == std::string::npos && parts->exponent.empty())
    (parts->digits.size() <= 3 ? of.has_small : of.has_large) = true;
  if (!evidence.decimal && !evidence.thousands && !evidence.ambiguous) return;
  const NumberPlace place{line, column, shortened(unquoted(text))};
  if (evidence.decimal) keep_first(sides_[*evidence.decimal == ','].decimal, place);
  if (evidence.thousands) keep_first(sides_[*evidence.thousands == ','].thousands, place);
  if (!evidence.ambiguous) return;
  keep_first(sides_[*evidence.ambiguous == ','].ambiguous, place);
  of.has_ambiguous[*evidence.ambiguous == ','] = true;
}

/// Returns true if the ambiguous marks can be thousands signs: each column with an ambiguous number also has
/// whole numbers of up to three digits, and none with more digits.
bool SignSurvey::separates_thousands(std::size_t side) const {
  return std::ranges::all_of(columns_, [&](const auto& each) {
    const Column& column = each.second;
    return !column.has_ambiguous[side] || (column.has_small && !column.has_large);
  });
}

std::optional<std::string> SignSurvey::contradiction() const {
  constexpr const char* advice = "expected one decimal sign and no thousands separators";
  const auto conflict = [&](const NumberPlace& one, const NumberPlace& other) {
    return fmt::format("{} and {} cannot be read with the same decimal sign, {}", one.described(),
                       other.described(), advice);
  };
  const auto& [point, comma] = sides_;
  if (point.decimal && comma.decimal) return conflict(*point.decimal, *comma.decimal);
  if (point.thousands && comma.thousands) return conflict(*point.thousands, *comma.thousands);
  for (std::size_t i = 0; i < 2; ++i) {
    const Side &side = sides_[i], &other = sides_[1 - i];
    if (side.decimal && side.thousands) return conflict(*side.decimal, *side.thousands);
    const std::optional<NumberPlace>& decides = other.decimal ? other.decimal : side.thousands;
    if (side.ambiguous && decides && !side.thousands && !separates_thousands(i))
      return conflict(*side.ambiguous, *decides);
    if (!side.ambiguous || side.decimal || side.thousands || other.decimal || other.thousands) continue;
    if (other.ambiguous) return conflict(*point.ambiguous, *comma.ambiguous);
    const bool is_mixed = std::ranges::any_of(columns_, [&](const auto& each) {
      return each.second.has_ambiguous[i] && each.second.has_small && !each.second.has_large;
    });
    if (is_mixed)
      return fmt::format("{}: its {} can be the decimal sign or separate thousands, {}",
                         side.ambiguous->described(), i == 0 ? "point" : "comma", advice);
  }
  return std::nullopt;
}

NumberSigns SignSurvey::found() const {
  const auto& [point, comma] = sides_;
  NumberSigns found;
  const bool is_comma =
      comma.decimal || point.thousands || (comma.ambiguous && !point.decimal && !comma.thousands);
  found.decimal = signs[is_comma];
  const Side &decimal = sides_[is_comma], &other = sides_[!is_comma];
  if (other.thousands || other.ambiguous) found.thousands = signs[!is_comma];
  if (found.thousands != '\0')
    found.note = fmt::format("{}: the {} is read as the separator of thousands",
                             (other.thousands ? other.thousands : other.ambiguous)->described(),
                             is_comma ? "point" : "comma");
  else if (decimal.ambiguous && !decimal.decimal)
    found.note = fmt::format("{}: the {} is taken as the decimal sign, though it can separate thousands",
                             decimal.ambiguous->described(), is_comma ? "comma" : "point");
  return found;
}

}  // namespace hystcan::config
