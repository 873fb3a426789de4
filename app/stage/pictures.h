// Draws pictures from CSV files with matplotlib (python/hystcan/plot.py).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::app {

struct PictureSize {
  double width_mm = 160.0;
  double height_mm = 100.0;
};

/// Returns the file extensions in which pictures can be drawn: svg, png, pdf.
const std::vector<std::string>& picture_formats();

/// A picture to draw. `kind` is the function in plot.py, `data` are its CSV files, `to` are the files to
/// draw, and `facts` are values that the CSV files do not contain, such as a title. All these files are in
/// the same folder as the file that lists the pictures (see draw_pictures()).
struct Picture {
  std::string kind;
  std::vector<std::string> data, to;
  PictureSize size{};
  nlohmann::json facts = nlohmann::json::object();
};

/// Writes the list of pictures to the file `list` and draws the pictures. `python3 -m hystcan.plot LIST` can
/// draw them again. If drawing fails, returns the reason and removes pictures that an earlier list left.
/// Throws RunError if the list cannot be written.
std::optional<std::string> draw_pictures(const std::filesystem::path& list,
                                         const std::vector<Picture>& pictures);

/// Converts a text to a valid file name that is not hidden. Each character that is not A-Z, a-z, 0-9, '.',
/// '-' or '+' becomes '_'.
std::string file_name_of(std::string_view text);

}  // namespace hystcan::app
