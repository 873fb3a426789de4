// Measured datasets as the commands that identify from them take them: files, a stretch of time, units.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::app {

struct DatasetInput {
  std::optional<double> from_s, to_s;
  std::string input_unit, output_unit;
};

/// Throws config::Error where the file tells (`# input_unit = "V"`, empty: it does not) another unit than
/// `expected`. `whose`: ends the sentence.
void refuse_other_unit(const std::filesystem::path& file, const char* name, const std::string& told,
                       const std::string& expected, const char* whose = "");

/// --from, --to, --input-unit, --output-unit.
void add_dataset_options(CLI::App& command, DatasetInput& input);

/// Units are the dataset's own, else the option's; V and um, and said so, where neither tells. Throws
/// config::Error, naming the file, where nothing is left of it, where dataset and option differ, or the units
/// of one file from another's.
std::vector<identification::Dataset> load_datasets(const std::vector<std::filesystem::path>& files,
                                                   const DatasetInput& input);

}  // namespace hystcan::app
