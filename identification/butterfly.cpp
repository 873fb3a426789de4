#include "identification/butterfly.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/text.h"
#include "identification/characterisation.h"
#include "identification/curve_basis.h"
#include "identification/regression.h"

namespace hystcan::identification {
namespace {

// Minimum reversal that counts as a turning point, as a share of the input span.
constexpr double least_input_swing = 0.02;
// Minimum depth of a valley on both sides, as a share of the output span.
constexpr double valley_depth = 0.05;
// The depth of a valley must also exceed this multiple of the noise, because noise alone makes the lowest of
// many samples much lower than the others.
constexpr double noisy_depth = 8.0;
// Minimum distance of a valley from the turning points, as a share of the swing.
constexpr double valley_distance = 0.05;
// Minimum weight of a sample, as a share of the largest weight. In a valley, the output hardly depends on the
// inner variable m, so that the weight would be near 0.
constexpr double least_weight = 0.02;
// Maximum change of the inner variable m of a sample in one Gauss-Newton step, as a share of the range of m.
// Near the valley, the linearised map would give a much larger change.
constexpr double longest_step = 0.2;
// A higher order of the output map is used only if the error falls below this share of the error with the
// lower order.
constexpr double worth_a_term = 0.98;
constexpr Eigen::Index first_regressor = 3, last_regressor = 6;
constexpr int most_passes = 8;
// Number of first passes that also select the shape of the reference curves; later passes keep the shape. A
// pass identifies the curves of the inner variable m, and then fits the output map.
constexpr int passes_with_shape = 3;

struct Swing {
  HalfCycle of;
  std::size_t lowest = 0;  // sample with the lowest output
  bool passes_valley = false;
};

std::vector<Swing> swings_of(const Dataset& dataset) {
  const double depth = valley_depth * span_of(dataset.output) + noisy_depth * noise_of(dataset.output);
  std::vector<Swing> swings;
  for (const HalfCycle& half : half_cycles(dataset, least_input_swing * span_of(dataset.input))) {
    const auto begin = dataset.output.begin() + static_cast<std::ptrdiff_t>(half.begin);
    const auto end = dataset.output.begin() + static_cast<std::ptrdiff_t>(half.end);
    Swing swing{half, half.begin, false};
    swing.lowest += static_cast<std::size_t>(std::min_element(begin, end) - begin);
    const double part = (dataset.input[swing.lowest] - half.from) / (half.to - half.from);
    swing.passes_valley = part > valley_distance &&
                          part<1.0 - valley_distance&& * begin> dataset.output[swing.lowest] + depth &&
                          *(end - 1) > dataset.output[swing.lowest] + depth;
    swings.push_back(swing);
  }
  return swings;
}

double valley_of(const Dataset& dataset, const std::vector<Swing>& swings) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Swing& swing : swings)
    if (swing.passes_valley) lowest = std::min(lowest, dataset.output[swing.lowest]);
  return lowest;
}

// Returns the side of the valley for each sample: -1 before it, 1 beyond it. In a swing without a valley, the
// side is 1 if the output rises with the input, and -1 if it falls. A swing that hardly changes the output is
// on the side of the previous swing.
std::vector<double> sides_of(const Dataset& dataset, const std::vector<Swing>& swings) {
  std::vector<double> sides(dataset.size(), 1.0);
  const double nothing = 0.2 * valley_depth * span_of(dataset.output);
  double last = 1.0;
  for (const Swing& swing : swings) {
    const double way = swing.of.to > swing.of.from ? 1.0 : -1.0;
    const double rise = dataset.output[swing.of.end - 1] - dataset.output[swing.of.begin];
    if (!swing.passes_valley && std::abs(rise) > nothing) last = rise * way > 0.0 ? 1.0 : -1.0;
    for (std::size_t i = swing.of.begin; i < swing.of.end; ++i)
      sides[i] = !swing.passes_valley ? last : i < swing.lowest ? -way : way;
    last = sides[swing.of.end - 1];
  }
  return sides;
}

// Scales the weights of all samples so that their mean square is 1. Returns the factor that converts a
// weighted error of the inner variable m to an error of the output x. `slope` is this factor before the
// weights are scaled.
double scale_weights(std::vector<Dataset>& datasets, double slope) {
  double largest = 0.0, square = 0.0, samples = 0.0;
  for (const Dataset& dataset : datasets)
    for (const double w : dataset.weight) largest = std::max(largest, w);
  for (Dataset& dataset : datasets)
    for (double& w : dataset.weight) {
      w = std::max(w, least_weight * largest);
      square += w * w;
      samples += 1.0;
    }
  const double mean = std::sqrt(square / samples);
  for (Dataset& dataset : datasets)
    for (double& w : dataset.weight) w /= mean;
  return slope * mean;
}

using Levels = std::vector<std::vector<double>>;  // inner variable m of each sample, for each dataset

std::vector<std::vector<double>> regressors_of(const std::vector<double>& levels, model::Interval inner) {
  std::vector<std::vector<double>> columns(last_regressor - first_regressor + 1);
  Eigen::VectorXd row(last_regressor + 1);
  for (const double m : levels) {
    chebyshev_row(inner, m, row);
    for (std::size_t i = 0; i < columns.size(); ++i)
      columns[i].push_back(row[first_regressor + static_cast<Eigen::Index>(i)]);
  }
  return columns;
}

struct Linear {
  std::vector<Dataset> datasets;  // datasets of the inner variable m
  double unit = 1.0;              // converts a weighted error of m to an error of the output x
};

Linear linear_datasets(const std::vector<Dataset>& given, const std::vector<double>& offsets,
                       const Levels& levels, const model::OutputMap& map) {
  const double longest = longest_step * map.inner().span();
  double largest = 0.0;
  for (const std::vector<double>& of : levels)
    for (const double m : of) largest = std::max(largest, std::abs(map.slope(m)));
  Linear linear{given};
  for (std::size_t i = 0; i < given.size(); ++i) {
    Dataset& dataset = linear.datasets[i];
    dataset.weight.resize(dataset.size());
    dataset.regressors = regressors_of(levels[i], map.inner());
    dataset.regressors.insert(dataset.regressors.end(), given[i].regressors.begin(),
                              given[i].regressors.end());
    for (std::size_t j = 0; j < dataset.size(); ++j) {
      const double m = levels[i][j], slope = map.slope(m);
      const double steep = std::copysign(std::max(std::abs(slope), least_weight * largest), slope);
      const double step = (given[i].output[j] - offsets[i] - map.value(m)) / steep;
      dataset.output[j] = m + std::clamp(step, -longest, longest);
      dataset.weight[j] = std::abs(slope);
    }
  }
  linear.unit = scale_weights(linear.datasets, 1.0);
  return linear;
}

Levels levels_of(const model::HysteresisParameters& curves, const Identified& found,
                 const std::vector<Dataset>& datasets) {
  const model::Hysteresis model(curves);
  Levels levels;
  for (std::size_t i = 0; i < datasets.size(); ++i)
    levels.push_back(predict(model, datasets[i], {found.delay_s}, found.memories[i]));
  return levels;
}

struct FittedMap {
  model::OutputMap map;
  double rms = 0.0;
};

class Butterfly {
 public:
  Butterfly(const std::vector<Dataset>& datasets, const IdentifyOptions& options,
            const IdentifyDatasets& curves)
      : given_(datasets), options_(options), curves_(curves) {
    options_.output = ShapeOfOutput::none;
    options_.common_gain = true;
    if (options_.creep_per_decade.value_or(0.0) != 0.0)
      refuse("a butterfly cannot have creep, expected a creep of 0");
    options_.creep_per_decade = 0.0;
  }

  Identified run() {
    unfold();
    Identified found = curves_(linear_.datasets, options_);
    FittedMap fitted = fit_map(found);
    for (int pass = 1; pass < most_passes && (!options_.go_on || options_.go_on()); ++pass) {
      linear_ = linear_datasets(given_, offsets_, levels_, fitted.map);
      if (pass >= passes_with_shape) options_.shape = found.search.shape;
      Identified next = curves_(linear_.datasets, options_);
      const double before = fitted.rms;
      const FittedMap refitted = fit_map(next);
      if (!(refitted.rms < before)) break;
      found = std::move(next);
      fitted = refitted;
      if (fitted.rms > 0.99 * before) break;
    }
    return finished(std::move(found), fitted);
  }

 private:
  void unfold() {
    double most = 0.0;
    std::vector<double> valleys;
    for (std::size_t i = 0; i < given_.size(); ++i) {
      const std::vector<Swing> swings = swings_of(given_[i]);
      valleys.push_back(valley_of(given_[i], swings));
      if (!std::isfinite(valleys.back()))
        refuse("dataset ", i + 1,
               " shows only one side of a butterfly: the output has no minimum inside a swing of the input, "
               "expected inputs of both signs");
      offsets_.push_back(options_.common_zero ? 0.0 : valleys[i] - valleys[0]);
      for (const double x : given_[i].output) most = std::max(most, x - valleys[i]);
    }
    for (std::size_t i = 0; i < given_.size(); ++i) {
      Dataset linear = given_[i];
      linear.regressors.clear();
      const std::vector<double> sides = sides_of(linear, swings_of(linear));
      linear.weight.resize(linear.size());
      for (std::size_t j = 0; j < linear.size(); ++j) {
        linear.output[j] = sides[j] * std::sqrt(std::max(0.0, linear.output[j] - valleys[i]) / most);
        linear.weight[j] = std::abs(linear.output[j]);
      }
      linear_.datasets.push_back(std::move(linear));
    }
    linear_.unit = scale_weights(linear_.datasets, 2.0 * most);
  }

  // Fits the output map from the present inner variable m to the outputs. If the fit of m found offsets
  // between the datasets, they are first added to the offsets of the outputs.
  FittedMap fit_map(const Identified& found) {
    levels_ = levels_of(found.parameters, found, linear_.datasets);
    for (std::size_t i = 0; i < given_.size(); ++i) offsets_[i] += linear_.unit * found.offsets[i];
    const model::Interval inner{found.parameters.ascending.value(found.parameters.input_range().lo),
                                found.parameters.upper_point().level};
    std::optional<FittedMap> best;
    for (int order = 2; order <= 8; ++order)
      if (std::optional<FittedMap> next = fitted(inner, order);
          next && (!best || next->rms < worth_a_term * best->rms))
        best = std::move(next);
    if (!best) refuse("no output map with a single minimum fits: check that the dataset is a butterfly");
    return *best;
  }

  std::optional<FittedMap> fitted(model::Interval inner, int order) const {
    std::size_t samples = 0;
    for (const Dataset& dataset : given_) samples += dataset.size();
    const std::size_t stride = std::max<std::size_t>(1, samples / 20000);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(order + 1, order + 1);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(order + 1), row(order + 1);
    double square = 0.0, count = 0.0;
    for (std::size_t i = 0; i < given_.size(); ++i)
      for (std::size_t j = 0; j < given_[i].size(); j += stride) {
        if (!options_.unseen.empty() && options_.unseen[i][j]) continue;
        const double x = given_[i].output[j] - offsets_[i];
        chebyshev_row(inner, levels_[i][j], row);
        H += row * row.transpose();
        g += x * row;
        square += x * x;
        count += 1.0;
      }
    const Eigen::VectorXd c = H.colPivHouseholderQr().solve(g);
    try {
      model::OutputMap map({c.begin(), c.end()}, inner);
      return FittedMap{std::move(map), std::sqrt(std::max(0.0, c.dot(H * c - 2.0 * g) + square) / count)};
    } catch (const std::invalid_argument&) {  // the map is not valid: it has a crest or a second valley
      return std::nullopt;
    }
  }

  // Scales the reference curves of the model `found`, so that the inner variable m covers the range from -1
  // to 1, and adds the output map to the model. Converts the errors in `found` from errors of m to errors of
  // the output x.
  Identified finished(Identified found, const FittedMap& fitted) const {
    const model::Interval& inner = fitted.map.inner();
    const double middle = 0.5 * (inner.lo + inner.hi), half = 0.5 * inner.span();
    model::HysteresisParameters& p = found.parameters;
    for (model::ReferenceCurve* curve : {&p.ascending, &p.descending}) {
      std::vector<double> coefficients = curve->coefficients();
      // Subtracts a constant from the curve. For a spline, this changes every coefficient, because the
      // B-splines add up to 1; for a Chebyshev series, it changes only the first coefficient.
      const bool all = curve->basis() == model::Basis::spline;
      for (std::size_t i = 0; i < coefficients.size(); ++i)
        coefficients[i] = (coefficients[i] - (all || i == 0 ? middle : 0.0)) / half;
      *curve = curve->with(coefficients);
    }
    p.output_map.emplace(fitted.map.coefficients(),
                         model::Interval{p.ascending.value(p.input_range().lo), p.upper_point().level});
    found.offsets = offsets_;
    for (double& drift : found.drifts) drift *= linear_.unit;
    measure(found);
    in_units_of_output(found);
    return found;
  }

  void measure(Identified& found) const {
    judge(found, given_);
    measure_span(found, given_);
    for (std::size_t i = 0; i < given_.size(); ++i)
      found.datasets[i] = characterise(given_[i], found.observed);
  }

  void in_units_of_output(Identified& found) const {
    const auto scale = [&](std::optional<double>& error) {
      if (error) *error *= linear_.unit;
    };
    scale(found.held_out_rms);
    scale(found.search.held_out);
    found.search.rms *= linear_.unit;
    for (Step& step : found.search.steps) {
      step.rms_before *= linear_.unit;
      step.rms_after *= linear_.unit;
      scale(step.held_out_before);
      scale(step.held_out_after);
    }
    for (ShapeScore& shape : found.search.shapes) {
      shape.rms *= linear_.unit;
      scale(shape.held_out);
    }
    if (!found.delay_range) return;
    found.delay_range->at_twice_the_rate *= linear_.unit;
    found.delay_range->at_five_times_the_rate *= linear_.unit;
  }

  const std::vector<Dataset>& given_;
  IdentifyOptions options_;
  const IdentifyDatasets& curves_;
  Linear linear_;
  Levels levels_;
  std::vector<double> offsets_;  // offset of each dataset, in units of the output x
};

}  // namespace

bool passes_valley(const Dataset& dataset) {
  return dataset.size() >= least_samples &&
         std::ranges::any_of(swings_of(dataset), [](const Swing& swing) { return swing.passes_valley; });
}

Identified identify_butterfly(const std::vector<Dataset>& datasets, const IdentifyOptions& options,
                              const IdentifyDatasets& curves) {
  return Butterfly(datasets, options, curves).run();
}

std::vector<Dataset> linearised(const std::vector<Dataset>& datasets, const Identified& identified) {
  model::HysteresisParameters curves = identified.parameters;
  curves.output_map.reset();
  return linear_datasets(datasets, identified.offsets, levels_of(curves, identified, datasets),
                         *identified.parameters.output_map)
      .datasets;
}

}  // namespace hystcan::identification
