// The plots of an identification's report. gnuplot draws them from the report's numbers
// (identification_numbers.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "identification/determination.h"
#include "identification/identify.h"

namespace hystcan::app {

struct Picture {
  std::string name;  ///< name.gp draws name.svg
  std::string title;
  std::string explanation;
};
const std::vector<Picture>& pictures();

/// Draws every plot whose numbers exist. Returns an empty text if all were drawn, else the reason of the
/// failure.
std::string draw_pictures(const std::filesystem::path& directory, std::size_t datasets,
                          const identification::Identified& identified,
                          const std::optional<identification::Landscape>& landscape);

}  // namespace hystcan::app
