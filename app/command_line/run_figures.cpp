#include "app/command_line/run_figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "config/files/csv.h"
#include "config/schema/settings.h"
#include "controller/control/axis.h"

namespace hystcan::app {
namespace {

constexpr std::size_t longest_step = 2'000'000;  // maximum number of rows that are searched for a step
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

const std::vector<std::string> needed{"time_s", "state", "reference_um", "position_um", "drive"};
const std::vector<std::string> wanted{"turnaround_us", "lateness_us", "sample_missing", "segment",
                                      "shape_time_s"};

std::vector<std::string> columns_of(const runs::Run& run, std::size_t axis) {
  std::vector<std::string> columns = needed;
  const std::vector<runs::Signal> present = run.signals(axis);
  for (const std::string& name : wanted)
    if (std::ranges::find(present, name, &runs::Signal::name) != present.end()) columns.push_back(name);
  return columns;
}

double rate_of(const runs::Run& run, std::size_t axis) {
  if (run.info().rate_Hz > 0.0) return run.info().rate_Hz;
  const std::vector<std::string> names{"time_s"};
  const runs::Columns columns =
      run.read(axis, names, {.from_s = run.info().first_s, .to_s = run.info().first_s + 1.0});
  const std::vector<double>& time_s = columns.front();
  if (time_s.size() < 2 || !(time_s.back() > time_s.front())) return 1000.0;
  return static_cast<double>(time_s.size() - 1) / (time_s.back() - time_s.front());
}

/// Delay in cycles from the drive in a command to the sample that shows its effect. The command takes effect
/// one cycle after it was sent, and acts for one more cycle before the next sample.
constexpr double cycles_of_the_wire = 2.0;

/// Delays the drive by a number of cycles. If this number is not an integer, interpolates linearly between
/// two drives.
class DelayedDrive {
 public:
  explicit DelayedDrive(double cycles)
      : whole_(static_cast<std::size_t>(cycles)),
        part_(cycles - static_cast<double>(whole_)),
        last_(whole_ + 2, nothing) {}

  double after(double drive) {
    std::shift_right(last_.begin(), last_.end(), 1);
    last_.front() = drive;
    return part_ > 0.0 ? last_[whole_] + part_ * (last_[whole_ + 1] - last_[whole_]) : last_[whole_];
  }

 private:
  std::size_t whole_;
  double part_;
  std::vector<double> last_;  ///< the last drives, newest first
};

/// Returns the delay in s from a drive to the position that it causes. If the run does not state the delay of
/// the axis, uses cycles_of_the_wire, the delay of the bus alone.
double drive_delay_s(const runs::RunAxis& axis, double rate_Hz) {
  constexpr double longest_cycles = 1000.0;
  const double cycles = axis.delay_s * rate_Hz;
  return (cycles >= 0.0 && cycles <= longest_cycles ? cycles : cycles_of_the_wire) / rate_Hz;
}

/// Returns the setting in_position.tolerance_um with which the run was recorded; 0 if it was not configured.
double tolerance_of(const runs::Run& run, std::size_t axis) {
  config::AxisConfig any;
  const double& tolerance_um = any.control.in_position.emplace().tolerance_um;
  const std::string key = fmt::format("axis[{}].{}", axis, path_of(any, tolerance_um));
  const auto& settings = run.info().settings;
  const auto found = std::ranges::find(settings, key, [](const auto& setting) { return setting.first; });
  if (found == settings.end()) return 0.0;
  const auto value = parsed_number<double>(found->second);
  if (!value) throw Error(run.path(), fmt::format("{} is '{}'", key, found->second), expect("a number"));
  return *value;
}

/// Collects the figures of one axis from its recorded cycles, in order of time.
class Gatherer {
 public:
  Gatherer(RunFigures& figures, const std::vector<std::string>& columns, double rate_Hz, double tolerance_um)
      : figures_(figures),
        turnaround_(place_in(columns, "turnaround_us")),
        lateness_(place_in(columns, "lateness_us")),
        missing_(place_in(columns, "sample_missing")),
        segment_(place_in(columns, "segment")),
        shape_time_(place_in(columns, "shape_time_s")),
        rate_Hz_(rate_Hz),
        tolerance_um_(tolerance_um),
        drive_(rate_Hz * figures.drive_delay_s) {}

  void take(std::span<const std::vector<double>> columns, std::size_t i) {
    const double acting = drive_.after(columns[4][i]);
    const bool tracks = columns[1][i] == static_cast<double>(controller::AxisState::tracking);
    const PlotRow row{columns[0][i], columns[2][i], columns[3][i], columns[2][i] - columns[3][i], acting};
    if (!tracks || !std::isfinite(row.error_um)) return figures_.spectrum.break_off();
    const auto value = [&](std::size_t column) {
      return column < columns.size() ? columns[column][i] : nothing;
    };
    // A step is a jump of the reference within a segment. In the transition to a segment, where shape_time_s
    // is 0, and in the first row of a segment, the reference can jump for another reason. Such rows do not
    // count in the search for a step.
    const bool is_between =
        value(shape_time_) == 0.0 || std::exchange(in_segment_, value(segment_)) != value(segment_);
    add(row, value(missing_) == 1.0, is_between);
    figures_.turnaround_us.add(value(turnaround_));  // Histogram::add() ignores values that are not finite
    figures_.lateness_us.add(value(lateness_));
  }

  void finish() {
    std::size_t begin = 0;
    figures_.step = metrics::largest_step({time_s_, level_um_, position_um_}, tolerance_um_, begin);
    if (!figures_.step) return;
    const std::size_t length = std::min(figures_.step->cycles, static_cast<std::size_t>(0.1 * rate_Hz_) + 10);
    for (std::size_t i = begin - std::min(begin, length / 5); i < begin + length; ++i)
      figures_.step_rows.push_back({time_s_[i] - time_s_[begin], reference_um_[i], position_um_[i],
                                    reference_um_[i] - position_um_[i], nothing});
  }

 private:
  static std::size_t place_in(const std::vector<std::string>& columns, const char* name) {
    return static_cast<std::size_t>(std::ranges::find(columns, name) - columns.begin());
  }

  /// Adds a tracking cycle. `is_missing`: the controller received no sample, so the position does not count
  /// in the step response. `is_between`: the reference is between two segments.
  void add(const PlotRow& row, bool is_missing, bool is_between) {
    figures_.error.add(row.error_um);
    figures_.rows.add(row);
    figures_.spectrum.add(row.error_um);
    if (time_s_.size() == longest_step) return;
    time_s_.push_back(row.time_s);
    reference_um_.push_back(row.reference_um);
    level_um_.push_back(is_between ? nothing : row.reference_um);
    position_um_.push_back(is_missing ? nothing : row.position_um);
  }

  RunFigures& figures_;
  /// Column indices. The index of a missing column is beyond the last column.
  std::size_t turnaround_, lateness_, missing_, segment_, shape_time_;
  double rate_Hz_, tolerance_um_;
  DelayedDrive drive_;
  double in_segment_ = nothing;
  std::vector<double> time_s_, reference_um_, position_um_;
  std::vector<double> level_um_;  ///< reference, for the search of steps; NaN between the segments
};

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
  TableRow row{config::in_one_line(run.run),
               config::in_one_line(run.axis),
               std::to_string(run.error.samples),
               fmt::format("{:.4f}", run.error.rms_um()),
               fmt::format("{:.4f}", run.error.max_um),
               percent_of(run.error.rms_um(), run.stroke_um),
               percent_of(run.error.max_um, run.stroke_um),
               std::to_string(run.faults),
               "",
               "",
               ""};
  if (!run.step) return row;
  row[8] = ms(run.step->rise_s());
  row[9] = fmt::format("{:.1f}", 100.0 * run.step->overshoot());
  row[10] = ms(run.step->settling_s());
  return row;
}

/// Escapes the text for a cell of a LaTeX table. Inserts {} before a leading [ or *, because LaTeX would take
/// this character as an argument of the \\ that ends the previous row.
std::string latex_text(std::string_view text) {
  return (text.starts_with('[') || text.starts_with('*') ? "{}" : "") +
         with_replaced(text, {{'\\', "\\textbackslash{}"},
                              {'^', "\\textasciicircum{}"},
                              {'~', "\\textasciitilde{}"},
                              {'<', "\\textless{}"},
                              {'>', "\\textgreater{}"},
                              {'|', "\\textbar{}"},
                              {'_', "\\_"},
                              {'%', "\\%"},
                              {'&', "\\&"},
                              {'#', "\\#"},
                              {'$', "\\$"},
                              {'{', "\\{"},
                              {'}', "\\}"}});
}

/// Escapes the text for a cell of a Markdown table, so that it cannot create HTML, a link or another cell.
std::string markdown_text(std::string_view text) {
  return with_replaced(text, {{'<', "&lt;"},
                              {'&', "&amp;"},
                              {'\\', "\\\\"},
                              {'`', "\\`"},
                              {'*', "\\*"},
                              {'[', "\\["},
                              {']', "\\]"},
                              {'|', "\\|"},
                              {'!', "\\!"}});
}

/// Adds an apostrophe before text that begins with = + - or @, because a spreadsheet would evaluate it as a
/// formula.
std::string spreadsheet_text(const std::string& text) {
  return !text.empty() && std::string_view("=+-@").find(text.front()) != std::string_view::npos ? "'" + text
                                                                                                : text;
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
    TableRow cells;
    for (const std::string& cell : rows[i]) cells.push_back(i == 0 ? cell : markdown_text(cell));
    text += fmt::format("| {} |\n", fmt::join(cells, " | "));
    if (i > 0) continue;
    text += "|---|---|";
    for (std::size_t column = 2; column < heading.size(); ++column) text += "---:|";
    text += '\n';
  }
  return text;
}

}  // namespace

void PlotRows::widen(Group& group, const PlotRow& row) {
  if (group.rows++ == 0) {
    group.first = group.second = row;
    return;
  }
  const bool first_is_least = group.first.error_um <= group.second.error_um;
  PlotRow least = first_is_least ? group.first : group.second;
  PlotRow greatest = first_is_least ? group.second : group.first;
  if (row.error_um < least.error_um) least = row;
  if (row.error_um > greatest.error_um) greatest = row;
  group.first = least.time_s <= greatest.time_s ? least : greatest;
  group.second = least.time_s <= greatest.time_s ? greatest : least;
}

void PlotRows::add(const PlotRow& row) {
  if (groups_.empty() || groups_.back().rows == group_rows_) {
    if (2 * groups_.size() == most) {
      for (std::size_t i = 0; i < groups_.size() / 2; ++i) {
        Group joined = groups_[2 * i];
        widen(joined, groups_[2 * i + 1].first);
        widen(joined, groups_[2 * i + 1].second);
        joined.rows = 2 * group_rows_;
        groups_[i] = joined;
      }
      groups_.resize(groups_.size() / 2);
      group_rows_ *= 2;
    }
    if (groups_.empty() || groups_.back().rows == group_rows_) groups_.emplace_back();
  }
  widen(groups_.back(), row);
}

std::vector<PlotRow> PlotRows::rows() const {
  std::vector<PlotRow> rows;
  for (const Group& group : groups_) {
    rows.push_back(group.first);
    if (group.second.time_s != group.first.time_s) rows.push_back(group.second);
  }
  return rows;
}

RunFigures figures_of(const runs::Run& run, std::size_t axis, const runs::TimeSpan& span) {
  const double rate_Hz = rate_of(run, axis);
  const runs::RunAxis& about = run.info().axes.at(axis);
  RunFigures figures{.run = run.name(),
                     .axis = about.name,
                     .drive_unit = about.drive_unit.empty() ? "drive unit" : about.drive_unit,
                     .stroke_um = about.stroke_um,
                     .drive_delay_s = drive_delay_s(about, rate_Hz),
                     .faults = about.faults.size(),
                     .rows = {},
                     .spectrum = metrics::Spectrum(rate_Hz),
                     .step = {},
                     .step_rows = {}};
  const std::vector<std::string> names = columns_of(run, axis);
  Gatherer gatherer(figures, names, rate_Hz, tolerance_of(run, axis));
  run.read_blocks({&axis, 1}, names, span, [&](std::size_t, std::span<const std::vector<double>> columns) {
    for (std::size_t i = 0; i < columns.front().size(); ++i) gatherer.take(columns, i);
  });
  if (figures.error.samples == 0)
    throw Error(run.path(), fmt::format("axis {} does not track in this interval", about.name),
                expect("cycles in the state tracking"));
  gatherer.finish();
  return figures;
}

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
  for (TableRow& row : rows) {
    for (std::string* name : {&row[0], &row[1]}) *name = config::csv_field(spreadsheet_text(*name));
    text += fmt::format("{}\n", fmt::join(row, ","));
  }
  return text;
}

}  // namespace hystcan::app
