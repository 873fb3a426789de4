// The numbers of an identification's report, in output units if not in percent; residual = measured - model.
//
//   record.csv       time_s,input,output,predicted,residual,dataset
//   curves.csv       input,ascending,descending
//   landscape.csv    k_ascending,k_descending,rms: an empty line after each row of the map, as gnuplot wants
//   it comparison.csv   model,parameters and its errors in percent of the output's span
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "identification/baselines/comparison.h"
#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::app {

/// Rows of record.csv: of more samples, one of each so many is written, the one that is missed by most.
inline constexpr std::size_t most_plotted = 20000;

/// One row of record.csv stands for so many samples.
std::size_t samples_per_row(const std::vector<identification::Dataset>& datasets);

/// record.csv, curves.csv, landscape.csv where there is one, comparison.csv. Throws RunError where one can't
/// be written.
void write_numbers(const std::filesystem::path& directory,
                   const std::vector<identification::Dataset>& datasets,
                   const identification::Identified& identified, const identification::Comparison& comparison,
                   const std::optional<identification::Landscape>& landscape);

}  // namespace hystcan::app
