// Plots recorded runs. The plotted data are kept as a CSV file beside each plot.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/run_figures.h"
#include "app/stage/pictures.h"

namespace hystcan::app {

/// Returns the names of the kinds of plot: "loops", "tracking", "error", "spectrum", "step", "timing" and
/// "comparison".
const std::vector<std::string>& plot_kinds();

struct RunPlots {
  std::filesystem::path folder;  ///< folder for the plots; must exist
  std::vector<std::string> kinds, formats;
  PictureSize size;
};

struct DrawnPlots {
  std::vector<std::string> names;      ///< file names of the plots, without extension
  std::vector<std::string> lacking;    ///< plots that could not be made, with the reason: "RUN-AXIS: the
                                       ///< reference of the run has no step"
  std::optional<std::string> undrawn;  ///< reason if plot.py failed and only the CSV files exist
};

/// Draws the plots. Throws RunError if a file cannot be written.
DrawnPlots draw_runs(const std::vector<RunFigures>& runs, const RunPlots& plots);

}  // namespace hystcan::app
