// The pictures of recorded runs, drawn by gnuplot from CSV files that stay beside them with the scripts.
#pragma once

#include <filesystem>
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
  std::vector<std::string> names;    ///< of the pictures, without their endings
  std::vector<std::string> lacking;  ///< "RUN-AXIS: no step in its reference"
  std::string undrawn;               ///< why gnuplot has drawn nothing; empty: it has
};

/// Throws RunError if a file cannot be written.
DrawnPlots draw_runs(const std::vector<RunFigures>& runs, const RunPlots& plots);

}  // namespace hystcan::app
