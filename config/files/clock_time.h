// Times of day in a column of time: 02:59:57.010, 2026-10-25T02:59:57.010Z, 25.10.2026 2:59:57,010 PM.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace hystcan::config {

struct ClockTime {
  double s = 0.0;         ///< since midnight
  std::string_view date;  ///< as in the file; empty: none
};

/// None if the text is no time with hours, minutes and seconds.
std::optional<ClockTime> clock_time(std::string_view text);
/// True for 2026-10-25, 25.10.2026, 10/25/26 and 25-Oct-2026.
bool is_date(std::string_view text);

/// Seconds since the first time of a column. A time that goes back by more than half a day is of the next
/// day.
class ClockColumn {
 public:
  /// None if the text is no time, if its date changes and no midnight is near, or if it goes back over one.
  std::optional<double> seconds(std::string_view text);

 private:
  std::optional<double> first_s_;
  double before_s_ = 0.0;
  double midnight_s_ = 0.0;  ///< of the present day
  std::string date_;
};

}  // namespace hystcan::config
