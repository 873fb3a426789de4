// Writes the report of an identification: a folder with an HTML page, its plots, the data of the plots as
// CSV, and the list of the plots (pictures.h). Values are in output units unless they are percentages.
//
//   record.csv      time_s,input,output,predicted,residual,record; residual = measured - model
//   curves.csv      input,ascending,descending
//   landscape.csv   k_ascending,k_descending,rms: error by convergence rates (k) of the model; an empty
//                   line where k_descending changes
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

/// Maximum number of rows in record.csv. If there are more samples, one row stands for a group of samples and
/// contains the sample with the largest residual.
inline constexpr std::size_t most_plotted = 20000;

/// Returns the number of samples for which one row of record.csv stands.
std::size_t samples_per_row(const std::vector<identification::Dataset>& datasets);

struct ReportPicture {
  std::string name;  ///< name of the file, without .svg
  std::string title;
  std::string explanation;
};
const std::vector<ReportPicture>& report_pictures();

struct IdentificationReport {
  const std::vector<identification::Dataset>& datasets;
  std::vector<std::string> names;  ///< file names of the datasets
  const identification::Identified& identified;
  std::vector<std::string> findings;  ///< observations and decisions for the engineer, one sentence each
  // write_report() sets the following members.
  identification::Comparison comparison{};
  std::optional<std::string> undrawn{};  ///< reason why a plot is missing; nullopt if all were drawn
};

/// Returns what the identification observed and decided, as sentences for the engineer.
std::vector<std::string> findings(const std::vector<identification::Dataset>& datasets,
                                  const identification::Identified& identified);

/// Returns the HTML page of a report. It needs no files except the plots in `directory`, and it names plots
/// that are missing.
std::string page_of(const std::filesystem::path& directory, const IdentificationReport& report);

/// Returns the names of all files that a report can contain. A new report replaces or removes these files of
/// an earlier report. It changes no other files in the folder.
const std::vector<std::string>& report_files();

/// Creates the folder and writes the report. Most of the time is spent on the comparison with other models
/// (identification/baselines/comparison.h). An earlier report stays until the new one is complete. After a
/// signal, writes the results found so far, and the page says so. Returns the reason if a plot is missing.
std::optional<std::string> write_report(const std::filesystem::path& directory, IdentificationReport report);

}  // namespace hystcan::app
