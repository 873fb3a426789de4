// The numbers of an identification's report. Values are in output units unless they are percentages.
//   residual = measured - model
//
//   record.csv      time_s,input,output,predicted,residual,record
//   curves.csv      input,ascending,descending
//   landscape.csv   k_ascending,k_descending,rms; an empty line follows each row of the map, for gnuplot
//   comparison.csv  model,parameters and the model's errors in percent of the output's span
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "identification/baselines/comparison.h"
#include "identification/dataset.h"
#include "identification/determination.h"
#include "identification/identify.h"

namespace hystcan::app {

/// Most rows of record.csv. If there are more samples, one row stands for a group of samples: the sample with
/// the largest residual.
inline constexpr std::size_t most_plotted = 20000;

/// The number of samples for which one row of record.csv stands.
std::size_t samples_per_row(const std::vector<identification::Dataset>& datasets);

/// Writes record.csv, curves.csv, comparison.csv and, if there is a landscape, landscape.csv. Throws
/// RunError if a file cannot be written.
void write_numbers(const std::filesystem::path& directory,
                   const std::vector<identification::Dataset>& datasets,
                   const identification::Identified& identified, const identification::Comparison& comparison,
                   const std::optional<identification::Landscape>& landscape);

}  // namespace hystcan::app
