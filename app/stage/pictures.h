// Pictures that matplotlib draws from CSV files (python/hystcan/plot.py).
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

/// Returns the file extensions of pictures: svg, png, pdf.
const std::vector<std::string>& picture_formats();

/// A picture: a function of plot.py, its CSV files, and data that the files do not contain, such as a title.
/// All files are in the folder of the list.
struct Picture {
  std::string kind;
  std::vector<std::string> data, to;
  PictureSize size{};
  nlohmann::json facts = nlohmann::json::object();
};

/// Writes the list of pictures and draws them; `python3 -m hystcan.plot LIST` can draw them again. If
/// pictures are missing, returns the reason and removes those of an earlier list. Throws RunError if the list
/// cannot be written.
std::optional<std::string> draw_pictures(const std::filesystem::path& list,
                                         const std::vector<Picture>& pictures);

/// Converts the text to a file name, or a part of one, that is valid in any folder and not hidden: it
/// contains only A-Z, a-z, 0-9, '.', '-', '+' and '_', which replaces every other character.
std::string file_name_of(std::string_view text);

}  // namespace hystcan::app
