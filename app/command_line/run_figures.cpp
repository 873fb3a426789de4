#include "app/command_line/run_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/error.h"
#include "controller/control/axis.h"

namespace hystcan::app {
namespace {

constexpr std::size_t longest_step = 2'000'000;  // rows in which a step is looked for
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

const std::vector<std::string> needed{"time_s", "state", "reference_um", "position_um", "drive"};
const std::vector<std::string> wanted{"turnaround_us", "lateness_us"};

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
  const runs::Signals times =
      run.read(axis, names, {.from_s = run.info().first_s, .to_s = run.info().first_s + 1.0});
  const std::vector<double>& time_s = times.columns.front();
  if (time_s.size() < 2 || !(time_s.back() > time_s.front())) return 1000.0;
  return static_cast<double>(time_s.size() - 1) / (time_s.back() - time_s.front());
}

/// A command takes effect a cycle after it was given and acts for another one, until the next sample.
constexpr double cycles_of_the_wire = 2.0;

/// The drive of some cycles before, between two of them where that is no whole number.
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
  std::vector<double> last_;  ///< the newest first
};

/// The known delay of the axis, else that of the wire.
double drive_delay_s(const runs::RunAxis& axis, double rate_Hz) {
  constexpr double longest_cycles = 1000.0;
  const double cycles = axis.delay_s * rate_Hz;
  return (cycles >= 0.0 && cycles <= longest_cycles ? cycles : cycles_of_the_wire) / rate_Hz;
}

/// Takes the cycles of an axis in order.
class Gatherer {
 public:
  Gatherer(RunFigures& figures, double rate_Hz)
      : figures_(figures), rate_Hz_(rate_Hz), drive_(rate_Hz * figures.drive_delay_s) {}

  void take(std::span<const std::vector<double>> columns, std::size_t i) {
    const double acting = drive_.after(columns[4][i]);
    const bool tracks = columns[1][i] == static_cast<double>(controller::AxisState::tracking);
    const PlotRow row{columns[0][i], columns[2][i], columns[3][i], columns[2][i] - columns[3][i], acting};
    if (!tracks || !std::isfinite(row.error_um)) return figures_.spectrum.break_off();
    add(row);
    if (columns.size() > 5) figures_.turnaround_us.add(columns[5][i]);
    if (columns.size() > 6) figures_.lateness_us.add(columns[6][i]);
  }

  void finish() {
    if (figures_.cycles > 0) figures_.rms_um = std::sqrt(squares_um2_ / static_cast<double>(figures_.cycles));
    figures_.step = step_response(time_s_, reference_um_, position_um_);
    if (!figures_.step) return;
    const StepResponse& step = *figures_.step;
    const std::size_t length = std::min(step.end - step.begin, static_cast<std::size_t>(0.1 * rate_Hz_) + 10);
    for (std::size_t i = step.begin - std::min(step.begin, length / 5); i < step.begin + length; ++i)
      figures_.step_rows.push_back({time_s_[i] - time_s_[step.begin], reference_um_[i], position_um_[i],
                                    reference_um_[i] - position_um_[i], nothing});
  }

 private:
  void add(const PlotRow& row) {
    ++figures_.cycles;
    squares_um2_ += row.error_um * row.error_um;
    figures_.max_um = std::max(figures_.max_um, std::abs(row.error_um));
    figures_.rows.add(row);
    figures_.spectrum.add(row.error_um);
    if (time_s_.size() == longest_step) return;
    time_s_.push_back(row.time_s);
    reference_um_.push_back(row.reference_um);
    position_um_.push_back(row.position_um);
  }

  RunFigures& figures_;
  double rate_Hz_;
  DelayedDrive drive_;
  double squares_um2_ = 0.0;
  std::vector<double> time_s_, reference_um_, position_um_;
};

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

void Histogram::add(double value) {
  if (!std::isfinite(value)) return;
  const double at = std::clamp(value / width, 0.0, static_cast<double>(counts.size() - 1));
  ++counts[static_cast<std::size_t>(at)];
}

std::uint64_t Histogram::total() const {
  std::uint64_t sum = 0;
  for (const std::uint64_t count : counts) sum += count;
  return sum;
}

RunFigures figures_of(const runs::Run& run, std::size_t axis, const runs::TimeSpan& span) {
  const double rate_Hz = rate_of(run, axis);
  const runs::RunAxis& about = run.info().axes.at(axis);
  RunFigures figures{.run = run.name(),
                     .axis = about.name,
                     .drive_unit = about.drive_unit.empty() ? "drive unit" : about.drive_unit,
                     .stroke_um = about.stroke_um,
                     .drive_delay_s = drive_delay_s(about, rate_Hz),
                     .faults = about.summary.faults.size(),
                     .rows = {},
                     .spectrum = Spectrum(rate_Hz),
                     .step = {},
                     .step_rows = {}};
  Gatherer gatherer(figures, rate_Hz);
  run.read_blocks({&axis, 1}, columns_of(run, axis), span,
                  [&](std::size_t, std::span<const std::vector<double>> columns) {
                    for (std::size_t i = 0; i < columns.front().size(); ++i) gatherer.take(columns, i);
                  });
  if (figures.cycles == 0)
    throw Error(fmt::format("{}: axis {} does not track there, expected cycles in the state tracking",
                            run.path().string(), about.name));
  gatherer.finish();
  return figures;
}

}  // namespace hystcan::app
