// The plots of recorded runs. The CSV files with the plotted data are kept beside the plots.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/run_figures.h"
#include "app/stage/pictures.h"

namespace hystcan::app {

/// Returns "loops", "tracking", "error", "spectrum", "step", "timing" and "comparison".
const std::vector<std::string>& plot_kinds();

struct RunPlots {
  std::filesystem::path folder;  ///< must exist
  std::vector<std::string> kinds, formats;
  PictureSize size;
};

struct DrawnPlots {
  std::vector<std::string> names;      ///< names of the plots, without endings
  std::vector<std::string> lacking;    ///< reasons for missing plots: "RUN-AXIS: its reference has no step"
  std::optional<std::string> undrawn;  ///< reason if the plots were not drawn
};

/// Throws RunError if a file can't be written.
DrawnPlots draw_runs(const std::vector<RunFigures>& runs, const RunPlots& plots);

}  // namespace hystcan::app
