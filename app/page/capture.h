// A capture of one axis at full rate around an event, from the history and the rows after the event.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/page/stream_rows.h"

namespace hystcan::app {

/// Indices, in a row of the controller's stream, of the columns that captures and events need.
struct CycleColumns {
  std::size_t count, time, axis, state, fault, reference, position, missing, line, turnaround, lateness;
  /// Throws Error if a column is missing.
  static CycleColumns of(const StreamGreeting& greeting);
};

struct Capture {
  std::vector<double> rows;
  std::size_t trigger_row = 0;
  double trigger_time_s = 0.0;
};

/// Returns the response to the reference step at the trigger: the figures of metrics/step_response.h, the
/// mean error in the last fifth of the response, and the duration of the response. Null if the reference does
/// not step at the trigger. `tolerance_um`: the settling band.
nlohmann::json step_of(const Capture& capture, const CycleColumns& at, double tolerance_um);

/// Makes a capture at each event.
class Trigger {
 public:
  /// Throws Error if the request is incomplete or out of range.
  Trigger(const nlohmann::json& request, const StreamGreeting& greeting);

  /// The event as named in the request.
  const std::string& name() const { return name_; }
  std::size_t axis() const { return axis_; }
  bool repeats() const { return repeats_; }
  /// Processes each row of the stream once, after it is in the history. Returns the capture when its last row
  /// arrived.
  std::optional<Capture> put(std::span<const double> row, const RowHistory& history);

 private:
  enum class On : std::uint8_t { step, level, fault, line, now };

  bool fires(std::span<const double> row) const;
  Capture collect(const RowHistory& history) const;

  CycleColumns at_;
  std::string name_;  ///< value of `on` in the request
  On on_ = On::now;
  std::size_t axis_ = 0;
  std::size_t signal_ = 0;               ///< column of the signal, for `level`
  double level_ = 0.0;                   ///< in the unit of the signal; for `step`: um in one cycle
  bool rising_ = true, falling_ = true;  ///< edges that count, for `level`
  double pre_s_ = 0.0;
  double post_s_ = 0.0;
  bool repeats_ = false;

  std::vector<double> before_;  ///< the previous row of this axis
  std::optional<double> fired_s_;
  double rests_until_s_ = -std::numeric_limits<double>::infinity();  ///< no event counts before this time
};

}  // namespace hystcan::app
