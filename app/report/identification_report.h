// What an identification found, for a person to read: a folder with one page, its pictures, the numbers they
// are drawn from, and the scripts that drew them.
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
  std::vector<std::string> findings;  ///< what was detected and decided, a sentence each
};

struct WrittenReport {
  identification::Comparison comparison;
  std::string undrawn;  ///< why a picture is missing; empty where none is
};

/// Names of all files that a report may hold: those of an earlier report are overwritten, or removed where
/// this one has none; nothing else in the folder is touched.
const std::vector<std::string>& report_files();

/// Throws config::Error where the name is taken by something else than a folder, RunError where it can't be
/// made.
void make_report_folder(const std::filesystem::path& directory);

/// Makes the folder, compares with the baselines (identification/baselines/comparison.h), which takes most of
/// the time, and writes. Where `go_on` says no, what there is so far is written, and the page says so.
WrittenReport write_report(const std::filesystem::path& directory, const IdentificationReport& report,
                           const std::function<bool()>& go_on);

}  // namespace hystcan::app
