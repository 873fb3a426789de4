#include "app/stage/run_dataset.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "config/files/dataset_file.h"
#include "controller/control/axis.h"
#include "runs/export.h"
#include "runs/run.h"

namespace hystcan::app {
namespace {

using identification::Dataset;

const std::vector<std::string> columns_of_a_run{"cycle", "time_s",      "state",
                                                "drive", "position_um", "sample_missing"};

struct Cycle {
  Cycle(std::span<const std::vector<double>> block, std::size_t row)
      : number(block[0][row]),
        time_s(block[1][row]),
        is_driven(controller::is_in_use(static_cast<controller::AxisState>(block[2][row]))),
        initialises(block[2][row] == static_cast<double>(controller::AxisState::initialising)),
        drive(block[3][row]),
        position_um(block[4][row]),
        sample_missing(block[5][row] != 0.0) {}

  double number, time_s;
  bool is_driven, initialises;
  double drive, position_um;
  bool sample_missing;
};

/// Takes the cycles of an axis in order.
class LongestStretch {
 public:
  explicit LongestStretch(std::string name) : name_(std::move(name)) {}

  void add(const Cycle& cycle) {
    const std::optional<Cycle> before = std::exchange(before_, cycle);
    if (!before || !before->is_driven || !cycle.is_driven || before->number + 1.0 != cycle.number)
      return end_stretch();
    const bool follows_arming = transitions_++ == 0;  // the cycle before commanded the safe drive
    const bool may_be_disabled = present_.size() == 0 && cycle.initialises && cycle.drive == before->drive;
    if (follows_arming || may_be_disabled) return;
    if (cycle.sample_missing)
      ++present_missing_;
    else
      append(cycle.time_s, before->drive, cycle.position_um);
  }

  void end_stretch() {
    if (present_.size() > 0) ++stretches_;
    if (present_.size() > longest_.size()) {
      std::swap(longest_, present_);
      missing_ = present_missing_;
    }
    present_ = {};
    present_missing_ = transitions_ = 0;
  }

  Dataset take() { return std::move(longest_); }

  std::string text() const {
    std::string text = fmt::format("{} from {:.10g} s to {:.10g} s", counted(longest_.size(), "row"),
                                   longest_.time_s.front(), longest_.time_s.back());
    if (stretches_ > 1)
      text += fmt::format(", the longest of {} stretches in which it is driven", stretches_);
    if (missing_ > 0) text += fmt::format(", without {} that had no sample", counted(missing_, "cycle"));
    return text;
  }
  bool is_empty() const { return longest_.size() == 0; }

 private:
  void append(double time_s, double drive, double position_um) {
    if (present_.size() == config::most_dataset_rows)
      throw Error(
          fmt::format("{}: the axis is driven for more than {} rows, expected a part of them "
                      "with --from and --to",
                      name_, config::most_dataset_rows));
    for (const double value : {time_s, drive, position_um})
      if (!(std::abs(value) <= identification::largest_value))
        throw Error(fmt::format("{}: a value is {} in cycle {}, expected at most {} in magnitude", name_,
                                value, before_->number, identification::largest_value));
    if (present_.size() > 0 && !(time_s > present_.time_s.back()))
      throw Error(fmt::format("{}: time_s is {} after {}, expected time to increase", name_, time_s,
                              present_.time_s.back()));
    present_.time_s.push_back(time_s);
    present_.input.push_back(drive);
    present_.output.push_back(position_um);
  }

  std::string name_;
  std::optional<Cycle> before_;
  Dataset present_, longest_;
  std::size_t transitions_ = 0;  ///< from one driven cycle to the next
  std::size_t present_missing_ = 0, missing_ = 0;
  std::size_t stretches_ = 0;
};

}  // namespace

bool is_recorded_run(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return true;
  try {
    runs::CycleReader reader(file);
    return true;
  } catch (const Error&) {
    return false;
  }
}

Dataset load_run(const std::filesystem::path& file, const std::string& axis, const runs::TimeSpan& span) {
  const runs::Run run(file);
  if (run.info().rows == 0) throw Error(fmt::format("{}: no rows, expected a run", file.string()));
  const std::size_t index = runs::axis_of(run, axis.empty() ? std::nullopt : std::optional(axis));
  const runs::RunAxis& about = run.info().axes[index];
  LongestStretch stretch(file.string());
  run.read_blocks({&index, 1}, columns_of_a_run, span,
                  [&](std::size_t, std::span<const std::vector<double>> block) {
                    for (std::size_t row = 0; row < block.front().size(); ++row)
                      stretch.add(Cycle(block, row));
                  });
  stretch.end_stretch();
  if (stretch.is_empty())
    throw Error(
        fmt::format("{}: axis {} is not driven there, expected cycles between {:g} and {:g} s "
                    "in which it is initialising, ready or tracking",
                    file.string(), about.name, run.info().first_s, run.info().last_s));
  note("hystcan: {}: axis {}, {}\n", file.string(), about.name, stretch.text());
  Dataset dataset = stretch.take();
  dataset.input_unit = about.drive_unit;
  dataset.output_unit = "um";
  return dataset;
}

}  // namespace hystcan::app
