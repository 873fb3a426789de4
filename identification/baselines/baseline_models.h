// Simple models (baselines) with which an identified model is compared. All are fitted by least squares to
// the same samples of the input v and the output x.
//
//   model                 equation                                                        parameters
//   average               x = p(v): one polynomial of order n, no memory                  n + 1
//   linear mapping        model/linear_mapping.h: f_0^A, f_0^D of orders n and m          n + m + 1
//   Prandtl-Ishlinskii    x = x_0 + w_0 v + sum w_i y_i: m plays y_i of v                 m + 2
//     free start          the same; the plays y_i at the first sample are fitted too      2 m + 2
//   Preisach              x = x_0 + w_0 v + sum w_ij relay_ij[v]: model/preisach.h        N (N + 1) / 2 + 2
//
// All weights w are 0 or more. N is the number of levels of the Preisach grid. The thresholds of the plays
// and relays are evenly spaced and do not count as parameters.
//
// The history before the first sample is usually not known, and a wrong history makes a model look worse than
// it is. Therefore each model with memory is fitted after each of four histories, and the best fit is kept:
//
//   - the given prehistory, if there is one;
//   - none: the model is in its virgin state at the first input;
//   - up to range.hi, then down to range.lo;
//   - down to range.lo, then up to range.hi.
//
// The memory of a model gets every sample. The fit uses at most 5000 samples of weight > 0, evenly chosen.
#pragma once

#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/hysteresis_parameters.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

struct Samples {
  std::vector<double> prehistory;  ///< inputs before the first sample; may be empty
  std::vector<double> input;       ///< input of each sample; if the model has a delay, already delayed
  std::vector<double> output;
  /// Weight of each squared error; 0 for a sample that is predicted but not fitted.
  std::vector<double> weight;
  model::Interval range;  ///< thresholds of the identified model
  /// Called before each run over the samples. If it returns false, the fit throws Stopped. If it is empty,
  /// the fit never stops.
  std::function<bool()> go_on{};
};

struct Stopped : std::runtime_error {
  Stopped() : std::runtime_error("stopped") {}
};

struct BaselineModel {
  std::string name;
  std::size_t parameters = 0;
  std::vector<double> prediction;  ///< predicted output of every sample, also of those with weight 0
};

// The following fits throw std::invalid_argument if the columns of the samples differ in length, if a number
// is not finite, if a weight is negative, if no weight is positive, or if range.lo < range.hi does not hold.

/// Fits the average model: one polynomial of the given order, 0 to 32, without memory.
BaselineModel fit_average(const Samples& samples, std::size_t order);

/// Fits a Preisach model. `levels`: number of rows of its grid of relays, at least one. If an input is
/// outside the range of the samples, the model gets a wider range.
BaselineModel fit_preisach(const Samples& samples, std::size_t levels);

/// A function that fits one baseline. The orders of its curves and its start values come from the identified
/// model.
using FitBaseline =
    std::function<BaselineModel(const Samples&, const model::HysteresisParameters& identified)>;

/// Returns the baselines of a report: average with the order of the descending curve; linear mapping;
/// Prandtl-Ishlinskii with 9 plays, with 30 plays, and with 30 plays and a free start; Preisach with 20
/// levels.
const std::vector<FitBaseline>& every_baseline();

}  // namespace hystcan::identification
