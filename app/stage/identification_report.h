// The report of an identification: a folder with one page, its plots, the numbers of the plots, and the
// scripts that draw them.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "identification/baselines/comparison.h"
#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::app {

struct IdentificationReport {
  const std::vector<identification::Dataset>& datasets;
  std::vector<std::string> names;  ///< of the datasets
  const identification::Identified& identified;
  std::vector<std::string> findings;  ///< observations and decisions, one sentence each
};

struct WrittenReport {
  identification::Comparison comparison;
  std::string undrawn;  ///< the reason why a plot is missing; empty if all are there
};

/// The names of all files that a report may hold. Files of an earlier report are overwritten, or removed if
/// this report has no such file. Other files in the folder do not change.
const std::vector<std::string>& report_files();

/// Creates the folder, compares with the baselines (identification/baselines/comparison.h), which takes
/// most of the time, and writes the report. When `go_on` returns false, it writes the results so far, and
/// the page says so.
WrittenReport write_report(const std::filesystem::path& directory, const IdentificationReport& report,
                           const std::function<bool()>& go_on);

}  // namespace hystcan::app
