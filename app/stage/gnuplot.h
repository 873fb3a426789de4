// Draws plots by gnuplot, if it is installed, from scripts that remain beside the plots.
//
// One look for all pictures: colours that colour-blind people tell apart, thin axes, the key above the plot,
// fonts that are readable in print. In gnuplot's words.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
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

/// Writes the script to directory/name and runs gnuplot on it there. Returns why not each picture, the
/// script's name with one of these endings ("svg", "png", "pdf"), is there and whole: gnuplot itself succeeds
/// on a full disk. After a failure the script remains for a later attempt, and no picture of its name. Throws
/// RunError if the script cannot be written.
std::optional<std::string> draw_with_gnuplot(const std::filesystem::path& directory, const std::string& name,
                                             const std::vector<std::string>& endings,
                                             std::string_view script);

/// The text as a gnuplot string constant, in quotes; control characters become spaces.
std::string gnuplot_string(std::string_view text);

/// Text that a picture shows as it is: without this, "_" and "^" would set what follows lower or higher.
std::string gnuplot_text(std::string_view text);

/// A file in the script's folder as a gnuplot string constant: never a command, which '|' and '<' would
/// begin.
std::string gnuplot_file(std::string_view name);

/// The text as the name of a file, or a part of one, in any folder: of A-Z, a-z, 0-9, '.', '-', '+' and '_',
/// which stands for all others, and not hidden.
std::string file_name_of(std::string_view text);

}  // namespace hystcan::app
