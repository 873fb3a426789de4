#include "identification/excerpt.h"

#include <algorithm>
#include <cmath>

#include "identification/creep_rows.h"

namespace hystcan::identification {
namespace {

constexpr std::size_t most_turning_points = 2000;  // in the search

}  // namespace

std::vector<TurningPoint> turning_points(const Dataset& dataset, double least_swing) {
  std::vector<TurningPoint> points;
  if (dataset.size() == 0) return points;
  std::size_t low = 0, high = 0;  // extremes since the last turning point
  int way = 0;
  for (std::size_t i = 1; i < dataset.size(); ++i) {
    const double v = dataset.input[i];
    if (v < dataset.input[low]) low = i;
    if (v > dataset.input[high]) high = i;
    if (way <= 0 && v - dataset.input[low] > least_swing) {
      if (way < 0) points.push_back({dataset.time_s[low], dataset.input[low]});
      way = 1;
      high = low = i;
    } else if (way >= 0 && dataset.input[high] - v > least_swing) {
      if (way > 0) points.push_back({dataset.time_s[high], dataset.input[high]});
      way = -1;
      high = low = i;
    }
  }
  return points;
}

double least_swing(const Dataset& dataset, double span) {
  double swing = 1e-5 * span;
  while (turning_points(dataset, swing).size() > most_turning_points) swing *= 2.0;
  return swing;
}

std::vector<HalfCycle> half_cycles(const Dataset& dataset, double least_swing) {
  std::vector<HalfCycle> halves;
  std::size_t begin = 0, i = 0;
  for (const TurningPoint& point : turning_points(dataset, least_swing)) {
    while (i < dataset.size() && dataset.time_s[i] < point.time_s) ++i;
    halves.push_back({begin, i + 1, dataset.input[begin], dataset.input[i]});
    begin = i;
  }
  halves.push_back({begin, dataset.size(), dataset.input[begin], dataset.input.back()});
  return halves;
}

Dataset folded(const Dataset& dataset) {
  Dataset folded = dataset;
  for (double& v : folded.input) v = std::abs(v);
  return folded;
}

Excerpt::Excerpt(const Dataset& dataset, std::vector<int> fold, std::size_t samples, double least_swing)
    : time_s_(dataset.time_s),
      input_(dataset.input),
      output_(dataset.output),
      weight_(dataset.weight),
      regressors_(dataset.regressors),
      fold_(std::move(fold)),
      stride_(std::max<std::size_t>(1, (dataset.size() + samples - 1) / samples)),
      turning_points_(turning_points(dataset, least_swing)) {
  if (fold_.empty()) fold_.assign(dataset.size(), 0);
  if (weight_.empty()) weight_.assign(dataset.size(), 1.0);
}

std::vector<double> Excerpt::outputs_without(const model::OutputCreep& creep) const {
  std::vector<bool> counts;
  counts.reserve(fold_.size());
  for (const int part : fold_) counts.push_back(part != Regression::left_out);
  return without_creep(creep, time_s_, output_, counts);
}

Excerpt::Sequence Excerpt::delayed_by(double delay_s, const model::OutputCreep& creep) const {
  Sequence sequence;
  const std::vector<double> at_once = creep.lags() > 0 ? outputs_without(creep) : std::vector<double>{};
  const std::vector<double>& outputs = creep.lags() > 0 ? at_once : output_;
  const std::size_t samples = (input_.size() + stride_ - 1) / stride_ + turning_points_.size();
  for (auto* column : {&sequence.time_s, &sequence.input, &sequence.output, &sequence.weight})
    column->reserve(samples);
  sequence.fold.reserve(samples);
  sequence.regressors.resize(regressors_.size());
  std::size_t next = 0, before = 0;
  for (std::size_t i = 0; i < input_.size(); i += stride_) {
    const double t = time_s_[i] - delay_s;
    for (; next < turning_points_.size() && turning_points_[next].time_s < t; ++next) {
      sequence.time_s.push_back(time_s_[i]);
      sequence.input.push_back(turning_points_[next].input);
      sequence.output.push_back(0.0);
      sequence.weight.push_back(0.0);
      for (std::vector<double>& column : sequence.regressors) column.push_back(0.0);
      sequence.fold.push_back(Regression::left_out);
    }
    while (before + 1 < input_.size() && time_s_[before + 1] <= t) ++before;
    double v = input_[before];
    if (t > time_s_[before] && before + 1 < input_.size())
      v += (input_[before + 1] - v) * (t - time_s_[before]) / (time_s_[before + 1] - time_s_[before]);
    sequence.time_s.push_back(time_s_[i]);
    sequence.input.push_back(v);
    sequence.output.push_back(outputs[i]);
    sequence.weight.push_back(weight_[i]);
    for (std::size_t r = 0; r < regressors_.size(); ++r) sequence.regressors[r].push_back(regressors_[r][i]);
    sequence.fold.push_back(fold_[i]);
  }
  return sequence;
}

}  // namespace hystcan::identification
