// The figures of a recorded run's tracking cycles, read once in constant memory, and their table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "metrics/spectrum.h"
#include "metrics/statistics.h"
#include "metrics/step_response.h"
#include "runs/run.h"

namespace hystcan::app {

/// A cycle in a plot.
struct PlotRow {
  double time_s, reference_um, position_um, error_um, drive;  ///< drive: the drive that caused this position
};

/// Keeps at most `most` rows of a signal of any length: of each group of neighbours, the rows with the
/// smallest and the largest error, so that no peak is lost.
class PlotRows {
 public:
  static constexpr std::size_t most = 20'000;

  void add(const PlotRow& row);
  /// Returns the rows in order of time.
  std::vector<PlotRow> rows() const;

 private:
  struct Group {
    PlotRow first, second;
    std::size_t rows = 0;
  };
  static void widen(Group& group, const PlotRow& row);

  std::vector<Group> groups_;
  std::size_t group_rows_ = 1;
};

struct RunFigures {
  std::string run, axis, drive_unit;
  double stroke_um = 0.0;      ///< 0: unknown
  double drive_delay_s = 0.0;  ///< each row has the drive that was recorded this long before its position
  metrics::ErrorStatistics error{};
  std::size_t faults = 0;
  PlotRows rows;
  metrics::Spectrum spectrum;  ///< spectrum of the error
  metrics::Histogram turnaround_us = metrics::Histogram::of_width(5.0, 199),
                     lateness_us = metrics::Histogram::of_width(1.0, 199);
  std::optional<metrics::Step> step;  ///< the largest step
  std::vector<PlotRow> step_rows;     ///< rows around the step
};

/// Throws Error if the axis does not track in this time span, or if a column is missing.
RunFigures figures_of(const runs::Run& run, std::size_t axis, const runs::TimeSpan& span);

/// Returns "markdown", "csv" and "latex".
const std::vector<std::string>& table_formats();
/// Returns a row for each run and axis: cycles, RMS and largest error in um and in percent of the stroke,
/// faults; rise time, overshoot and settling time if there is a step. Unknown values are empty.
std::string run_table(const std::vector<RunFigures>& runs, std::string_view format);

}  // namespace hystcan::app
