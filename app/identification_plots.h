// Numbers and pictures of an identification's report.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "identification/comparison.h"
#include "identification/identify.h"
#include "identification/record.h"

namespace hystcan::app {

/// Rows of record.csv: of more samples, one of each so many is written, the one that is missed by most.
inline constexpr std::size_t most_plotted = 20000;

struct Picture {
  std::string name;  ///< name.gp draws name.svg
  std::string title;
  std::string explanation;
};
const std::vector<Picture>& pictures();

/// One row of record.csv stands for so many samples.
std::size_t samples_per_row(const std::vector<identification::Record>& records);

/// record.csv, curves.csv, landscape.csv where there is one, comparison.csv. Throws RunError where one can't
/// be written.
void write_numbers(const std::filesystem::path& directory, const std::vector<identification::Record>& records,
                   const identification::Identified& identified, const identification::Comparison& comparison,
                   const std::optional<identification::Landscape>& landscape);

/// Draws what there are numbers of. Empty where all was drawn, else why not.
std::string draw_pictures(const std::filesystem::path& directory, std::size_t records,
                          const identification::Identified& identified,
                          const std::optional<identification::Landscape>& landscape);

}  // namespace hystcan::app
