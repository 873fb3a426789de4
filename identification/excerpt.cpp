#include "identification/excerpt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "identification/quasi_static.h"
#include "identification/regression.h"
#include "identification/separable_fit.h"

namespace hystcan::identification {

Excerpt::Excerpt(const Dataset& dataset, std::span<const int> fold, std::size_t samples, double least_swing)
    : dataset_(&dataset),
      fold_(fold),
      stride_(std::max<std::size_t>(1, (dataset.size() + samples - 1) / samples)),
      turning_points_(turning_points(dataset, least_swing)) {}

std::vector<double> Excerpt::outputs_without(const model::OutputCreep& creep) const {
  std::vector<bool> counts;
  counts.reserve(fold_.size());
  for (const int part : fold_) counts.push_back(part != Regression::left_out);
  return without_creep(creep, dataset_->time_s, dataset_->output, counts);
}

// Returns the outputs of the kept samples without creep, for any weight of the creep. The outputs depend
// smoothly on the weight. They are computed once at some Chebyshev points and interpolated between these,
// with an error of 1e-9 of the creep.
std::vector<double> Excerpt::kept_without(const model::OutputCreep& creep) const {
  constexpr int points = 12;
  constexpr double weights = 0.5 * most_creep_per_decade;
  const auto angle = [](int j) { return std::numbers::pi * (j + 0.5) / points; };
  const auto weight = [&](int j) { return 0.5 * weights * (1.0 + std::cos(angle(j))); };
  if (without_creep_.size() == 0) {
    const auto sample_count = static_cast<Eigen::Index>((dataset_->size() + stride_ - 1) / stride_);
    without_creep_.resize(sample_count, points);
    for (int j = 0; j < points; ++j) {
      const std::vector<double> all = outputs_without(model::OutputCreep(creep_of(2.0 * weight(j))));
      for (Eigen::Index i = 0; i < sample_count; ++i)
        without_creep_(i, j) = all[static_cast<std::size_t>(i) * stride_];
    }
  }
  Eigen::VectorXd share(points);
  for (int j = 0; j < points; ++j) {
    share[j] = std::sin(angle(j)) * (j % 2 == 0 ? 1.0 : -1.0) / (creep.weight() - weight(j));
    if (!std::isfinite(share[j])) {
      share = Eigen::VectorXd::Unit(points, j);
      break;
    }
  }
  const Eigen::VectorXd outputs = without_creep_ * (share / share.sum());
  return {outputs.begin(), outputs.end()};
}

Dataset Excerpt::delayed_by(double delay_s, const model::OutputCreep& creep) const {
  Dataset excerpt;
  const std::vector<double>&time_s = dataset_->time_s, &input = dataset_->input, &weight = dataset_->weight;
  const std::vector<std::vector<double>>& regressors = dataset_->regressors;
  const bool creeps = creep.lags() > 0;
  const std::vector<double> at_once = !creeps        ? std::vector<double>{}
                                      : stride_ == 1 ? outputs_without(creep)
                                                     : kept_without(creep);
  const std::size_t samples = (input.size() + stride_ - 1) / stride_ + turning_points_.size();
  for (auto* column : {&excerpt.time_s, &excerpt.input, &excerpt.output, &excerpt.weight})
    column->reserve(samples);
  excerpt.fold.reserve(samples);
  excerpt.regressors.resize(regressors.size());
  std::size_t next = 0, before = 0;
  for (std::size_t i = 0; i < input.size(); i += stride_) {
    const double t = time_s[i] - delay_s;
    for (; next < turning_points_.size() && time_s[turning_points_[next]] < t; ++next) {
      excerpt.time_s.push_back(time_s[i]);
      excerpt.input.push_back(input[turning_points_[next]]);
      excerpt.output.push_back(0.0);
      excerpt.weight.push_back(0.0);
      for (std::vector<double>& column : excerpt.regressors) column.push_back(0.0);
      excerpt.fold.push_back(Regression::left_out);
    }
    while (before + stride_ <= i && time_s[before + stride_] <= t) before += stride_;
    while (before < i && time_s[before + 1] <= t) ++before;
    double v = input[before];
    if (t > time_s[before] && before + 1 < input.size())
      v += (input[before + 1] - v) * (t - time_s[before]) / (time_s[before + 1] - time_s[before]);
    excerpt.time_s.push_back(time_s[i]);
    excerpt.input.push_back(v);
    excerpt.output.push_back(creeps ? at_once[i / stride_] : dataset_->output[i]);
    excerpt.weight.push_back(weight.empty() ? 1.0 : weight[i]);
    for (std::size_t r = 0; r < regressors.size(); ++r) excerpt.regressors[r].push_back(regressors[r][i]);
    excerpt.fold.push_back(fold_.empty() ? 0 : fold_[i]);
  }
  return excerpt;
}

}  // namespace hystcan::identification
