// The demo's picture, drawn by gnuplot from the CSV files that the demo has written.
#pragma once

#include <filesystem>
#include <string>

namespace hystcan::app {

struct DemoPlot {
  std::filesystem::path
      directory;  ///< holds average.csv ... inverse+pi.csv; gets demo.gp, demo.svg, demo.png
  std::string title;
  std::string axis;  ///< name, as in the CSV
  std::string drive_unit;
  double stroke_um = 1.0;
  double from_s = 0.0;  ///< stretch of time shown in the tracking panel
  double to_s = 1.0;
};

/// Writes demo.gp and runs gnuplot on it. Empty where it drew, else why not; the script stays for a later
/// try.
std::string draw(const DemoPlot& plot);

}  // namespace hystcan::app
