// The report of an identification: a folder with one page, its plots, the data of the plots, and the list of
// the plots (pictures.h). Values are in output units unless they are percentages.
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

/// Maximum number of rows in record.csv. If there are more samples, one row represents a group of samples: it
/// contains the sample with the largest residual.
inline constexpr std::size_t most_plotted = 20000;

/// Returns how many samples one row of record.csv represents.
std::size_t samples_per_row(const std::vector<identification::Dataset>& datasets);

struct ReportPicture {
  std::string name;  ///< the file is `name`.svg
  std::string title;
  std::string explanation;
};
const std::vector<ReportPicture>& report_pictures();

struct IdentificationReport {
  const std::vector<identification::Dataset>& datasets;
  std::vector<std::string> names;  ///< names of the datasets
  const identification::Identified& identified;
  std::vector<std::string> findings;  ///< observations and decisions, one sentence each
  // Results of writing the report:
  identification::Comparison comparison{};
  std::optional<std::string> undrawn{};  ///< why a plot is missing
};

/// Returns the observations and decisions of an identification as sentences for the engineer.
std::vector<std::string> findings(const std::vector<identification::Dataset>& datasets,
                                  const identification::Identified& identified);

/// Returns the page of a report as HTML that needs only the plots in `directory`. The page lists missing
/// plots.
std::string page_of(const std::filesystem::path& directory, const IdentificationReport& report);

/// Returns the names of all files that a report may contain. Files of an earlier report are overwritten, or
/// removed if the new report has no such file. Other files in the folder do not change.
const std::vector<std::string>& report_files();

/// Creates the folder, compares with the baselines (identification/baselines/comparison.h), which takes most
/// of the time, and writes the report. An earlier report stays until the new one is complete. At a signal,
/// writes the results so far, with a remark on the page. Returns the reason if a plot is missing.
std::optional<std::string> write_report(const std::filesystem::path& directory, IdentificationReport report);

}  // namespace hystcan::app
