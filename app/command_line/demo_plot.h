// The plot of the demo. gnuplot draws it from the CSV files that the demo has written.
#pragma once

#include <filesystem>
#include <string>

namespace hystcan::app {

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

/// Writes demo.gp and runs gnuplot on it. Returns an empty text on success, else the reason of the failure.
/// The script remains for a later attempt.
std::string draw(const DemoPlot& plot);

}  // namespace hystcan::app
