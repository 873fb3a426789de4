// Errors of runs as a table.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/command_line/run_figures.h"

namespace hystcan::app {

/// "markdown", "csv", "latex".
const std::vector<std::string>& table_formats();
/// A row for each run and axis: cycles, RMS and greatest error in um and in percent of the stroke, faults; rise time,
/// overshoot and settling time where there is a step. What is unknown is empty.
std::string run_table(const std::vector<RunFigures>& runs, std::string_view format);

}  // namespace hystcan::app
