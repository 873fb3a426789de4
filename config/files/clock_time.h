// Reads times of day in a time column. Examples: 02:59:57.010, 2026-10-25T02:59:57.010Z,
// 25.10.2026 2:59:57,010 PM.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace hystcan::config {

struct ClockTime {
  double s = 0.0;         ///< seconds since midnight
  std::string_view date;  ///< date as it is written in the file; empty if the time has no date
};

/// Parses a time of day, with or without a date. Returns nullopt if the text is not a time with hours,
/// minutes and seconds.
std::optional<ClockTime> clock_time(std::string_view text);
/// Returns true for dates such as 2026-10-25, 25.10.2026, 10/25/26 and 25-Oct-2026.
bool is_date(std::string_view text);

/// Converts a column of times of day to seconds since its first time. A time that is more than half a day
/// earlier than the time before it belongs to the next day.
class ClockColumn {
 public:
  /// Converts the next time of the column. Returns nullopt in three cases. The text is not a time. Or the
  /// date is new, but the time of day did not fall by more than half a day, as it does after midnight. Or a
  /// time without a date rises by more than half a day: it is then from the day before.
  std::optional<double> seconds(std::string_view text);

 private:
  std::optional<double> first_s_;
  double before_s_ = 0.0;
  double midnight_s_ = 0.0;  ///< start of the present day, in seconds since the start of the first day
  std::string date_;
};

}  // namespace hystcan::config
