// The pictures of recorded runs and of the demo, drawn by gnuplot from CSV files that stay beside them with
// the scripts.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/run_figures.h"
#include "app/stage/gnuplot.h"

namespace hystcan::app {

/// "loops", "tracking", "error", "spectrum", "step", "timing", "comparison".
const std::vector<std::string>& plot_kinds();

struct RunPlots {
  std::filesystem::path folder;  ///< is there
  std::vector<std::string> kinds, formats;
  PictureSize size;
};

struct DrawnPlots {
  std::vector<std::string> names;      ///< of the pictures, without their endings
  std::vector<std::string> lacking;    ///< "RUN-AXIS: no step in its reference"
  std::optional<std::string> undrawn;  ///< why gnuplot has not drawn them
};

/// Throws RunError if a file cannot be written.
DrawnPlots draw_runs(const std::vector<RunFigures>& runs, const RunPlots& plots);

struct DemoPlot {
  /// Holds average.csv ... inverse+pi.csv; draw() adds demo.gp, demo.svg and demo.png.
  std::filesystem::path directory;
  std::string title;
  std::string axis;  ///< name, as in the CSV
  std::string drive_unit;
  double stroke_um = 1.0;
  double delay_cycles = 2.0;  ///< from a drive to the sample that shows its effect
  double from_s = 0.0;        ///< interval of time in the tracking panel
  double to_s = 1.0;
};

/// Writes demo.gp and runs gnuplot on it. Returns why there is no picture; the script remains for a later
/// attempt.
std::optional<std::string> draw(const DemoPlot& plot);

}  // namespace hystcan::app
