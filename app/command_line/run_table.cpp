#include "app/command_line/run_table.h"

#include <fmt/format.h>

namespace hystcan::app {
namespace {

using TableRow = std::vector<std::string>;

const TableRow heading{"run",     "axis",   "cycles",    "RMS [um]",      "max [um]",    "RMS [%]",
                       "max [%]", "faults", "rise [ms]", "overshoot [%]", "settled [ms]"};

std::string percent_of(double value_um, double stroke_um) {
  return stroke_um > 0.0 ? fmt::format("{:.3f}", 100.0 * value_um / stroke_um) : "";
}

TableRow row_of(const RunFigures& run) {
  const auto ms = [](const std::optional<double>& time_s) {
    return time_s ? fmt::format("{:.1f}", 1e3 * *time_s) : "";
  };
  TableRow row{run.run,
               run.axis,
               std::to_string(run.cycles),
               fmt::format("{:.4f}", run.rms_um),
               fmt::format("{:.4f}", run.max_um),
               percent_of(run.rms_um, run.stroke_um),
               percent_of(run.max_um, run.stroke_um),
               std::to_string(run.faults),
               "",
               "",
               ""};
  if (!run.step) return row;
  row[8] = ms(run.step->rise_s);
  row[9] = fmt::format("{:.1f}", run.step->overshoot_percent);
  row[10] = ms(run.step->settled_s);
  return row;
}

std::string latex_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '_' || c == '%' || c == '&' || c == '#' || c == '$') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string latex(const std::vector<TableRow>& rows) {
  std::string text = "\\begin{tabular}{ll" + std::string(heading.size() - 2, 'r') + "}\n\\hline\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    TableRow cells;
    for (const std::string& cell : rows[i]) cells.push_back(latex_text(cell));
    text += fmt::format("{} \\\\\n{}", fmt::join(cells, " & "), i == 0 ? "\\hline\n" : "");
  }
  return text + "\\hline\n\\end{tabular}\n";
}

std::string markdown(const std::vector<TableRow>& rows) {
  std::string text;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    text += fmt::format("| {} |\n", fmt::join(rows[i], " | "));
    if (i > 0) continue;
    text += "|---|---|";
    for (std::size_t column = 2; column < heading.size(); ++column) text += "---:|";
    text += '\n';
  }
  return text;
}

}  // namespace

const std::vector<std::string>& table_formats() {
  static const std::vector<std::string> formats{"markdown", "csv", "latex"};
  return formats;
}

std::string run_table(const std::vector<RunFigures>& runs, std::string_view format) {
  std::vector<TableRow> rows{heading};
  for (const RunFigures& run : runs) rows.push_back(row_of(run));
  if (format == "latex") return latex(rows);
  if (format == "markdown") return markdown(rows);
  std::string text;
  for (const TableRow& row : rows) text += fmt::format("{}\n", fmt::join(row, ","));
  return text;
}

}  // namespace hystcan::app
