// The pictures of an identification's report, drawn by gnuplot from its numbers (identification_numbers.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "identification/identify.h"

namespace hystcan::app {

struct Picture {
  std::string name;  ///< name.gp draws name.svg
  std::string title;
  std::string explanation;
};
const std::vector<Picture>& pictures();

/// Draws what there are numbers of. Empty where all was drawn, else why not.
std::string draw_pictures(const std::filesystem::path& directory, std::size_t datasets,
                          const identification::Identified& identified,
                          const std::optional<identification::Landscape>& landscape);

}  // namespace hystcan::app
