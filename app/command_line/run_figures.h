// Computes the figures of a recorded run (errors, faults, step response, timing) in its tracking cycles, and
// prints them as a table. The run is read once, in constant memory.
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

/// The values of one cycle in a plot.
struct PlotRow {
  /// `drive` is the drive that caused this position. The drive was recorded `drive_delay_s` before the
  /// position.
  double time_s, reference_um, position_um, error_um, drive;
};

/// Reduces a signal of any length to at most `most` rows. From each group of neighbouring rows it keeps the
/// two rows with the smallest and the largest error, so that no peak is lost.
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
  double stroke_um = 0.0;      ///< stroke of the axis in um; 0: unknown
  double drive_delay_s = 0.0;  ///< time from a drive to the position that it causes
  metrics::ErrorStatistics error{};
  std::size_t faults = 0;
  PlotRows rows;
  metrics::Spectrum spectrum;  ///< spectrum of the tracking error
  metrics::Histogram turnaround_us = metrics::Histogram::of_width(5.0, 199),
                     lateness_us = metrics::Histogram::of_width(1.0, 199);
  std::optional<metrics::Step> step;  ///< response to the largest step of the reference; nullopt if there is
                                      ///< no step
  std::vector<PlotRow> step_rows;     ///< rows around the largest step
};

/// Reads the run and returns the figures of one axis. Throws Error if the axis does not track within `span`,
/// or if a required column is missing.
RunFigures figures_of(const runs::Run& run, std::size_t axis, const runs::TimeSpan& span);

/// Returns the names of the table formats: "markdown", "csv" and "latex".
const std::vector<std::string>& table_formats();
/// Returns a table with one row for each run and axis: number of cycles, RMS and largest error in um and in
/// percent of the stroke, number of faults. If the reference has a step, the row also has rise time,
/// overshoot and settling time. Cells with unknown values are empty.
std::string run_table(const std::vector<RunFigures>& runs, std::string_view format);

}  // namespace hystcan::app
