// One look for all pictures: colours that colour-blind people tell apart, thin axes, the key above the plot, fonts that are
// readable in print. In gnuplot's words.
#pragma once

#include <string>
#include <vector>

namespace hystcan::app {

struct PictureSize {
  double width_mm = 160.0;
  double height_mm = 100.0;
};

/// The endings of pictures: svg, png, pdf.
const std::vector<std::string>& picture_formats();

/// Settings and line styles:
///
///   ls 1 blue, ls 2 vermilion, ls 3 green, ls 4 purple, ls 5 grey, ls 6 black
///
/// Without colour, dashes tell them apart: 1 and 6 are solid.
std::string plot_look();

/// Draws `body` once for each format, to NAME.FORMAT.
std::string drawn_as(const std::string& name, const std::vector<std::string>& formats,
                     const PictureSize& size, const std::string& body);

}  // namespace hystcan::app
