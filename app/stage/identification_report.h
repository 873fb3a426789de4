// The report of an identification: a folder with one page, its plots, the numbers of the plots, and the list
// of the plots (pictures.h). Values are in output units unless they are percentages.
//   residual = measured - model
//
//   record.csv      time_s,input,output,predicted,residual,record
//   curves.csv      input,ascending,descending
//   landscape.csv   k_ascending,k_descending,rms; an empty line follows each row of the map
//   comparison.csv  model,parameters and the model's errors in percent of the output's span
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "identification/baselines/comparison.h"
#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::app {

/// Most rows of record.csv. If there are more samples, one row stands for a group of samples: the sample with
/// the largest residual.
inline constexpr std::size_t most_plotted = 20000;

/// The number of samples for which one row of record.csv stands.
std::size_t samples_per_row(const std::vector<identification::Dataset>& datasets);

struct ReportPicture {
  std::string name;  ///< name.svg
  std::string title;
  std::string explanation;
};
const std::vector<ReportPicture>& report_pictures();

struct IdentificationReport {
  const std::vector<identification::Dataset>& datasets;
  std::vector<std::string> names;  ///< of the datasets
  const identification::Identified& identified;
  std::vector<std::string> findings;  ///< observations and decisions, one sentence each
  // What writing it has found:
  identification::Comparison comparison{};
  std::optional<std::string> undrawn{};  ///< why a plot is missing
};

/// The observations and decisions of an identification, in sentences for the engineer.
std::vector<std::string> findings(const std::vector<identification::Dataset>& datasets,
                                  const identification::Identified& identified);

/// The page of a report: HTML that needs only the plots beside it, in `directory`. It names those that are
/// missing.
std::string page_of(const std::filesystem::path& directory, const IdentificationReport& report);

/// The names of all files that a report may hold. Files of an earlier report are overwritten, or removed if
/// this report has no such file. Other files in the folder do not change.
const std::vector<std::string>& report_files();

/// Creates the folder, compares with the baselines (identification/baselines/comparison.h), which takes
/// most of the time, and writes the report; an earlier one stays until this one is whole. At a signal, it
/// writes the results so far, and the page says so. Returns why a plot is missing, if one is.
std::optional<std::string> write_report(const std::filesystem::path& directory, IdentificationReport report);

}  // namespace hystcan::app
