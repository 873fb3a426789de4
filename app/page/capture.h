// Captures the rows of one axis at the full cycle rate, before and after an event, like the trigger of an
// oscilloscope.
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

/// Indices of the stream columns that captures and events need; `count` is the number of columns in a row.
struct CycleColumns {
  std::size_t count, time, axis, state, fault, reference, position, missing, line, turnaround, lateness;
  /// Finds the columns by name. Throws Error if a column is missing.
  static CycleColumns of(const StreamGreeting& greeting);
};

struct Capture {
  std::vector<double> rows;
  std::size_t trigger_row = 0;
  double trigger_time_s = 0.0;
};

/// Returns the response to a step of the reference at the trigger row: the figures of
/// metrics/step_response.h, the mean error in the last fifth of the response, and the duration of the
/// response. Returns null if the reference has no step there. `tolerance_um`: settling band.
nlohmann::json step_of(const Capture& capture, const CycleColumns& at, double tolerance_um);

/// Waits for an event in the stream, such as a step of the reference, and then makes a capture.
class Trigger {
 public:
  /// `request`: the client's request (docs/page_protocol.md). Throws Error if it is incomplete or a value is
  /// out of range.
  Trigger(const nlohmann::json& request, const StreamGreeting& greeting);

  /// Returns the kind of event: "step", "level", "fault", "line" or "now".
  const std::string& name() const { return name_; }
  std::size_t axis() const { return axis_; }
  bool repeats() const { return repeats_; }
  /// Call this function once for each row of the stream, after the row was added to `history`. Returns a
  /// capture if the row is the last one of the capture.
  std::optional<Capture> put(std::span<const double> row, const RowHistory& history);

 private:
  enum class On : std::uint8_t { step, level, fault, line, now };

  bool fires(std::span<const double> row) const;
  Capture collect(const RowHistory& history) const;

  CycleColumns at_;
  std::string name_;  ///< kind of event, as written in the request
  On on_ = On::now;
  std::size_t axis_ = 0;
  std::size_t signal_ = 0;               ///< index of the watched column; only for the event "level"
  double level_ = 0.0;                   ///< "level": value to cross; "step": reference step to exceed, um
  bool rising_ = true, falling_ = true;  ///< "level": directions in which a crossing is an event
  double pre_s_ = 0.0;
  double post_s_ = 0.0;
  bool repeats_ = false;

  std::vector<double> before_;  ///< previous row of this axis
  std::optional<double> fired_s_;
  /// Events before this time are ignored: after a capture, the next event must be at least pre_s_ and
  /// at least 0.2 s later, so that captures do not overlap.
  double rests_until_s_ = -std::numeric_limits<double>::infinity();
};

}  // namespace hystcan::app
