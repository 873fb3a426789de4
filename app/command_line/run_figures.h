// What the pictures and the table of a recorded run are made from: its tracking cycles, read once in constant memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/spectrum.h"
#include "app/command_line/step_response.h"
#include "runs/run.h"

namespace hystcan::app {

/// A cycle in a picture.
struct PlotRow {
  double time_s, reference_um, position_um, error_um, drive;  ///< drive: the one that this sample shows
};

/// Keeps at most `most` rows of a signal, whatever its length: of each group of neighbours the rows with the least and the
/// greatest error, so that no peak is lost.
class PlotRows {
 public:
  static constexpr std::size_t most = 20'000;

  void add(const PlotRow& row);
  /// In order of time.
  std::vector<PlotRow> rows() const;
  /// Of one group.
  std::size_t group_rows() const { return group_rows_; }

 private:
  struct Group {
    PlotRow first, second;
    std::size_t rows = 0;
  };
  static void widen(Group& group, const PlotRow& row);

  std::vector<Group> groups_;
  std::size_t group_rows_ = 1;
};

/// Counts of values in classes of equal width.
struct Histogram {
  double width = 1.0;
  std::vector<std::uint64_t> counts;  ///< the last class takes all that is greater
  Histogram(double class_width, std::size_t classes) : width(class_width), counts(classes) {}
  void add(double value);
  std::uint64_t total() const;
};

struct RunFigures {
  std::string run, axis, drive_unit;
  double stroke_um = 0.0;      ///< 0: unknown
  double drive_delay_s = 0.0;  ///< by which the drive of the rows is earlier than the one in the record
  std::uint64_t cycles = 0;
  double rms_um = 0.0, max_um = 0.0;
  std::size_t faults = 0;
  PlotRows rows;
  Spectrum spectrum;  ///< of the error
  Histogram turnaround_us{5.0, 200}, lateness_us{1.0, 200};
  std::optional<StepResponse> step;
  std::vector<PlotRow> step_rows;  ///< around the step
};

/// Throws Error if the axis does not track in this time, or if a column is missing.
RunFigures figures_of(const runs::Run& run, std::size_t axis, const runs::TimeSpan& span);

}  // namespace hystcan::app
