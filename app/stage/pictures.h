// Pictures, which matplotlib draws from CSV files (python/hystcan/plot.py).
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

/// The endings of pictures: svg, png, pdf.
const std::vector<std::string>& picture_formats();

/// A picture: a function of plot.py, its CSV files, and what it cannot read there, such as a title. All files
/// are in the folder of the list.
struct Picture {
  std::string kind;
  std::vector<std::string> data, to;
  PictureSize size{};
  nlohmann::json facts = nlohmann::json::object();
};

/// Writes the list of pictures, from which `python3 -m hystcan.plot LIST` draws them again, and draws them.
/// Returns why pictures are missing; those of an earlier list are then removed. Throws RunError if the list
/// cannot be written.
std::optional<std::string> draw_pictures(const std::filesystem::path& list,
                                         const std::vector<Picture>& pictures);

/// The text as the name of a file, or a part of one, in any folder: of A-Z, a-z, 0-9, '.', '-', '+' and '_',
/// which stands for all others, and not hidden.
std::string file_name_of(std::string_view text);

}  // namespace hystcan::app
