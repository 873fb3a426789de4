#include "config/files/clock_time.h"

#include <algorithm>
#include <cstddef>

#include "config/files/csv.h"
#include "config/files/record_words.h"

namespace hystcan::config {
namespace {

constexpr double day_s = 86'400.0;

/// Reads a number of one or two digits before the character `end`. Removes number and `end` from the text.
/// Returns nullopt if the text does not begin with such a number.
std::optional<double> leading(std::string_view& text, char end) {
  const std::size_t size = text.find(end);
  if (size == 0 || size > 2 || !std::all_of(text.data(), text.data() + size, is_digit)) return std::nullopt;
  double value = 0.0;
  for (const char c : text.substr(0, size)) value = 10.0 * value + (c - '0');
  text.remove_prefix(size + 1);
  return value;
}

/// Returns true for the short English name of a month in any case, as in 04-Mar-2026.
bool names_a_month(std::string_view text) {
  constexpr std::string_view months = " jan feb mar apr may jun jul aug sep oct nov dec ";
  return months.find(" " + lower_case(text) + " ") != std::string_view::npos;
}

}  // namespace

bool is_date(std::string_view text) {
  const std::size_t month = text.find_first_not_of("0123456789");
  if (text.size() >= 9 && text.size() <= 11 && month < text.size() && text[month] == '-' &&
      text[text.size() - 5] == '-')
    return names_a_month(text.substr(month + 1, text.size() - month - 6)) && is_digit(text.front()) &&
           std::ranges::all_of(text.substr(text.size() - 4), is_digit);
  if (text.size() < 6 || text.size() > 10 || !is_digit(text.front()) || !is_digit(text.back())) return false;
  for (const char mark : {'-', '.', '/'})
    if (std::ranges::count(text, mark) == 2)
      return std::ranges::all_of(text, [mark](char c) { return is_digit(c) || c == mark; });
  return false;
}

std::optional<ClockTime> clock_time(std::string_view text) {
  text = unquoted(text);
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  ClockTime time;
  if (const std::size_t before = text.find_last_of(" T", colon); before != std::string_view::npos) {
    time.date = trimmed(text.substr(0, before));
    if (!is_date(time.date)) return std::nullopt;
    text.remove_prefix(before + 1);
  }
  const std::optional<double> hours = leading(text, ':');
  const std::optional<double> minutes = hours ? leading(text, ':') : std::nullopt;
  if (!minutes || text.empty() || !is_digit(text.front())) return std::nullopt;
  const std::size_t end = std::min(text.size(), text.find_first_not_of("0123456789.,"));
  const std::optional<double> seconds = csv_number(text.substr(0, end), true);
  const std::string zone = lower_case(trimmed(text.substr(end)));
  const bool is_zone = zone == "z" || zone.starts_with('+') || zone.starts_with('-');
  if (!seconds || (!zone.empty() && !is_zone && zone != "am" && zone != "pm")) return std::nullopt;
  if (*hours >= 24.0 || *minutes >= 60.0 || *seconds >= 61.0) return std::nullopt;
  double hour = *hours;
  if (zone == "am" && hour == 12.0) hour = 0.0;
  if (zone == "pm" && hour < 12.0) hour += 12.0;
  time.s = 3600.0 * hour + 60.0 * *minutes + *seconds;
  return time;
}

std::optional<double> ClockColumn::seconds(std::string_view text) {
  const std::optional<ClockTime> time = clock_time(text);
  if (!time) return std::nullopt;
  const bool other_date = first_s_ && date_ != time->date;
  const bool next_day = first_s_ && time->s < before_s_ - 0.5 * day_s && (other_date || time->date.empty());
  const bool is_back = first_s_ && time->date.empty() && time->s > before_s_ + 0.5 * day_s;
  if ((other_date && !next_day) || is_back) return std::nullopt;
  if (next_day) midnight_s_ += day_s;
  if (!first_s_) first_s_ = time->s;
  if (date_ != time->date) date_ = time->date;
  before_s_ = time->s;
  return midnight_s_ + time->s - *first_s_;
}

}  // namespace hystcan::config
