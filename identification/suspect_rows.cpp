#include "identification/suspect_rows.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include "identification/characterisation.h"

namespace hystcan::identification {
namespace {

constexpr std::size_t half_window = 8;
constexpr double many_times_noise = 20.0;
constexpr double share_of_range = 0.02;
constexpr double many_local_steps = 10.0;
constexpr double many_usual_steps = 3.0;
// Number of the largest steps from row to row that do not count, because the drive may jump at the beginning
// or the end of a record.
constexpr std::size_t ignored_large_steps = 3;
// If there are more runs of suspect inputs than this share of all rows, and more than `always_glitches`, they
// are pulses of the excitation and not glitches.
constexpr double most_glitches = 0.002;
constexpr std::size_t always_glitches = 3;
// The output follows a jump of the input if it moves by more than this share of the jump times the mean gain.
constexpr double follows = 0.3;

double quantile(std::vector<double> values, double share) {
  const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + place);
  return values[static_cast<std::size_t>(place)];
}

double usual_range(const std::vector<double>& values) {
  return quantile(values, 0.99) - quantile(values, 0.01);
}

std::vector<double> steps_of(std::span<const double> values) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < values.size(); ++i) steps.push_back(std::abs(values[i] - values[i - 1]));
  return steps;
}

std::span<const double> window(const std::vector<double>& values, std::size_t row) {
  const std::size_t first = row > half_window ? row - half_window : 0;
  return std::span(values).subspan(first, std::min(values.size(), row + half_window + 1) - first);
}

std::vector<bool> marked(const std::vector<SuspectRow>& suspects, std::size_t rows) {
  std::vector<bool> is_suspect(rows, false);
  for (const SuspectRow& suspect : suspects) is_suspect[suspect.row] = true;
  return is_suspect;
}

/// Returns the rows whose value is too far from the median of the rows around it. The distance must exceed
/// the limits for all rows, and also allowed(row), the limit for this row.
std::vector<SuspectRow> suspects_of(const std::vector<double>& values,
                                    const std::function<double(std::size_t)>& allowed) {
  std::vector<SuspectRow> suspects;
  const double least = std::max(many_times_noise * noise_of(values), share_of_range * usual_range(values));
  std::vector<bool> is_near_jump(values.size(), false);
  for (std::size_t i = 1; i < values.size(); ++i)
    if (std::abs(values[i] - values[i - 1]) > 0.5 * least)
      for (std::size_t j = i - std::min(i, half_window); j < std::min(values.size(), i + half_window); ++j)
        is_near_jump[j] = true;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!is_near_jump[i]) continue;
    const auto around = window(values, i);
    const double usual = median({around.begin(), around.end()}), distance = std::abs(values[i] - usual);
    if (distance > least && distance > many_local_steps * quantile(steps_of(around), 0.75) &&
        distance > allowed(i))
      suspects.push_back({i, false, values[i], usual});
  }
  if (suspects.empty()) return suspects;
  std::vector<double> steps;
  const std::vector<bool> is_suspect = marked(suspects, values.size());
  for (std::size_t i = 1; i < values.size(); ++i)
    if (!is_suspect[i] && !is_suspect[i - 1]) steps.push_back(std::abs(values[i] - values[i - 1]));
  if (steps.size() <= ignored_large_steps) return {};
  std::ranges::nth_element(steps, steps.begin() + ignored_large_steps, std::greater<>());
  const double usual_step = steps[ignored_large_steps];
  std::erase_if(suspects, [&](const SuspectRow& suspect) {
    return std::abs(suspect.value - suspect.usual) <= many_usual_steps * usual_step;
  });
  return suspects;
}

std::size_t runs_in(const std::vector<SuspectRow>& suspects) {
  std::size_t runs = 0;
  for (std::size_t i = 0; i < suspects.size(); ++i)
    runs += i == 0 || suspects[i].row != suspects[i - 1].row + 1 ? 1 : 0;
  return runs;
}

double mean_gain(const Dataset& dataset) {
  const double range = usual_range(dataset.input);
  return range > 0.0 ? usual_range(dataset.output) / range : 0.0;
}

bool is_followed(const Dataset& dataset, const SuspectRow& glitch) {
  const auto around = window(dataset.output, glitch.row);
  const double distance = std::abs(dataset.output[glitch.row] - median({around.begin(), around.end()}));
  return distance > follows * mean_gain(dataset) * std::abs(glitch.value - glitch.usual);
}

/// Removes those suspect inputs that are only the jump of the drive at the beginning or end of the record.
void leave_jumps_at_ends(std::vector<SuspectRow>& suspects, const Dataset& dataset) {
  const std::vector<double>& input = dataset.input;
  model::Interval others{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  const std::vector<bool> is_suspect = marked(suspects, input.size());
  for (std::size_t i = 0; i < input.size(); ++i)
    if (!is_suspect[i]) others = {std::min(others.lo, input[i]), std::max(others.hi, input[i])};
  // Range of rows without the suspects at both ends of the record.
  std::size_t first = 0, last = input.size();
  while (first < last && is_suspect[first]) ++first;
  while (last > first && is_suspect[last - 1]) --last;
  const double slack = share_of_range * others.span();
  std::erase_if(suspects, [&](const SuspectRow& suspect) {
    const bool is_at_end = suspect.row < first || suspect.row >= last;
    const bool is_within = suspect.value >= others.lo - slack && suspect.value <= others.hi + slack;
    return is_at_end && (is_within || is_followed(dataset, suspect));
  });
}

/// Returns the suspect inputs. Returns `nullopt` if there are so many that they are pulses of the excitation.
std::optional<std::vector<SuspectRow>> suspect_inputs(const Dataset& dataset) {
  const std::vector<double>& input = dataset.input;
  std::vector<SuspectRow> suspects = suspects_of(input, [](std::size_t) { return 0.0; });
  if (suspects.empty()) return suspects;
  leave_jumps_at_ends(suspects, dataset);
  const double most =
      std::max(static_cast<double>(always_glitches), most_glitches * static_cast<double>(input.size()));
  if (static_cast<double>(runs_in(suspects)) > most) return std::nullopt;
  for (SuspectRow& suspect : suspects) suspect.of_input = true;
  return suspects;
}

std::vector<SuspectRow> suspect_outputs(const Dataset& dataset, const std::vector<SuspectRow>& glitches) {
  std::vector<double> input = dataset.input;
  for (const SuspectRow& glitch : glitches) input[glitch.row] = glitch.usual;
  const double gain = mean_gain(dataset);
  return suspects_of(dataset.output, [&](std::size_t row) {
    const std::vector<double> steps = steps_of(window(input, row));
    return many_local_steps * gain * *std::ranges::max_element(steps);
  });
}

constexpr std::size_t least_rows_at_end = 5;
// Minimum number of rows with the output at the end of the sensor's range, as a share of all rows.
constexpr double least_share_at_end = 0.01;
// Minimum travel of the input while the output stays at the end of the sensor's range, as a share of the
// input range.
constexpr double moves = 0.05;
// Minimum slope of the output beside rows at the end of the sensor's range, as a share of the mean slope of
// the output. If a material saturates instead, this slope is smaller.
constexpr double as_steep = 0.3;

class AtEnd {
 public:
  AtEnd(const Dataset& dataset, double value)
      : dataset_(dataset), value_(value), range_(range_of(dataset.input).span()) {
    mean_slope_ = span_of(dataset.output) / range_;
  }

  std::size_t rows() const {
    std::size_t rows = 0;
    for (std::size_t begin = 0, end = 0; begin < dataset_.size(); begin = std::max(end, begin + 1)) {
      if (dataset_.output[begin] != value_) continue;
      for (end = begin; end < dataset_.size() && dataset_.output[end] == value_; ++end) {
      }
      if (end - begin >= least_rows_at_end && stands_still(begin, end)) rows += end - begin;
    }
    return rows;
  }

 private:
  double step(std::size_t row) const { return std::abs(dataset_.input[row] - dataset_.input[row - 1]); }

  bool stands_still(std::size_t begin, std::size_t end) const {
    std::vector<double> steps;
    for (std::size_t i = begin + 1; i < end; ++i) steps.push_back(step(i));
    // The largest steps of the drive do not count: with a delay, the output stays constant for some rows
    // after the drive has jumped, although the sensor is not saturated.
    std::ranges::sort(steps, std::greater<>());
    double travel = 0.0;
    for (std::size_t i = ignored_large_steps; i < steps.size(); ++i) travel += steps[i];
    if (!(travel >= moves * range_)) return false;
    const double beside = moves * range_, rise = as_steep * mean_slope_;
    double before = 0.0, after = 0.0;
    std::size_t first = begin, last = end - 1;
    while (first > 0 && before < beside) before += step(first--);
    while (last + 1 < dataset_.size() && after < beside) after += step(++last);
    return std::abs(dataset_.output[first] - value_) > rise * before ||
           std::abs(dataset_.output[last] - value_) > rise * after;
  }

  const Dataset& dataset_;
  double value_, range_, mean_slope_ = 0.0;
};

}  // namespace

std::vector<SuspectRow> suspect_rows(const Dataset& dataset) {
  if (dataset.size() < least_samples) return {};
  std::optional<std::vector<SuspectRow>> suspects = suspect_inputs(dataset);
  if (!suspects) return {};
  const std::vector<SuspectRow> outputs = suspect_outputs(dataset, *suspects);
  suspects->insert(suspects->end(), outputs.begin(), outputs.end());
  std::ranges::stable_sort(*suspects, {}, &SuspectRow::row);
  return *suspects;
}

std::vector<SensorEnd> sensor_ends(const Dataset& dataset) {
  std::vector<SensorEnd> ends;
  if (dataset.size() < least_samples || !(span_of(dataset.input) > 0.0)) return ends;
  const model::Interval range = range_of(dataset.output);
  for (const bool is_upper : {false, true}) {
    const double value = is_upper ? range.hi : range.lo;
    const std::size_t rows = AtEnd(dataset, value).rows();
    if (static_cast<double>(rows) > least_share_at_end * static_cast<double>(dataset.size()))
      ends.push_back({value, is_upper, rows});
  }
  return ends;
}

Dataset without_rows(const Dataset& dataset, const std::vector<SuspectRow>& suspects) {
  Dataset kept{.input_unit = dataset.input_unit, .output_unit = dataset.output_unit};
  auto next = suspects.begin();
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    while (next != suspects.end() && next->row < i) ++next;
    if (next != suspects.end() && next->row == i) continue;
    kept.time_s.push_back(dataset.time_s[i]);
    kept.input.push_back(dataset.input[i]);
    kept.output.push_back(dataset.output[i]);
  }
  return kept;
}

bool has_same_rows(const Dataset& a, const Dataset& b) {
  const Dataset &longer = a.size() < b.size() ? b : a, &shorter = a.size() < b.size() ? a : b;
  if (shorter.size() < least_samples) return false;
  constexpr double same = 1e-6;  // tolerance, as a share of the range of a column
  const double near_in = same * span_of(shorter.input), near_out = same * span_of(shorter.output),
               near_s = same * span_of(shorter.time_s);
  const auto elapsed_s = [](const Dataset& of, std::size_t from, std::size_t to) {
    return of.time_s[to] - of.time_s[from];
  };
  // Tries each row `first` of the longer dataset as the start of the shorter dataset. Compares the row with
  // the highest input of the shorter dataset before all other rows, because at a wrong start its input
  // usually differs. The first rows would not show a wrong start, because many records begin at rest.
  const auto highest =
      static_cast<std::size_t>(std::ranges::max_element(shorter.input) - shorter.input.begin());
  for (std::size_t first = 0; first + shorter.size() <= longer.size(); ++first) {
    if (std::abs(longer.input[first + highest] - shorter.input[highest]) > near_in) continue;
    std::size_t i = 0;
    while (i < shorter.size() && std::abs(longer.input[first + i] - shorter.input[i]) <= near_in &&
           std::abs(longer.output[first + i] - shorter.output[i]) <= near_out &&
           std::abs(elapsed_s(longer, first, first + i) - elapsed_s(shorter, 0, i)) <= near_s)
      ++i;
    if (i == shorter.size()) return true;
  }
  return false;
}

}  // namespace hystcan::identification
