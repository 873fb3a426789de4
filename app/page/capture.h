// A capture of one axis at full rate around an event, from what is already in the history and what follows.
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

/// Where the columns that captures and events need are in a row of the controller's stream.
struct CycleColumns {
  std::size_t count, time, axis, state, fault, reference, position, missing, line, turnaround, lateness;
  /// Throws Error if one is missing.
  static CycleColumns of(const nlohmann::json& greeting);
};

struct Trigger {
  enum class On : std::uint8_t { step, level, fault, line, now };
  enum class Edge : std::uint8_t { rising, falling, either };

  On on = On::now;
  Edge edge = Edge::either;
  std::size_t axis = 0;
  std::size_t signal = 0;  ///< column; of `level`
  double level = 0.0;      ///< in the unit of the signal; of `step`: um in one cycle
  double pre_s = 0.0;
  double post_s = 0.0;
  bool repeat = false;
  std::string name{};  ///< of `on`, as it was asked for

  /// Throws Error where the request is incomplete or out of range.
  static Trigger of(const nlohmann::json& request, const nlohmann::json& greeting);
};

struct Capture {
  std::vector<double> rows;
  std::size_t trigger_row = 0;
  double trigger_time_s = 0.0;
};

/// The response to the step of the reference at the trigger: the figures of metrics/step_response.h, the mean
/// error of the last fifth of it, and its time. Null where the reference does not step there. `tolerance_um`:
/// of the settling band.
nlohmann::json step_of(const Capture& capture, const CycleColumns& at, double tolerance_um);

class CaptureTrigger {
 public:
  CaptureTrigger(Trigger trigger, const CycleColumns& columns) : trigger_(std::move(trigger)), at_(columns) {}

  const Trigger& trigger() const { return trigger_; }
  /// Each row of the stream once, after it is in the history. The capture, when its last row has come.
  std::optional<Capture> put(std::span<const double> row, const RowHistory& history);

 private:
  bool fires(std::span<const double> row) const;
  Capture collect(const RowHistory& history) const;

  Trigger trigger_;
  CycleColumns at_;
  std::vector<double> before_;  ///< the row of this axis before
  std::optional<double> fired_s_;
  double rests_until_s_ = -std::numeric_limits<double>::infinity();  ///< captures do not overlap
};

}  // namespace hystcan::app
