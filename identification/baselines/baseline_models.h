// Baseline models for comparison with an identified model. All are fitted by least squares to the same
// samples.
//
//   model                 equation                                                        parameters
//   average               x = p(v): one polynomial, no memory                             n + 1
//   linear mapping        model/linear_mapping.h: f_0^A, f_0^D of orders n and m          n + m + 1
//   Prandtl-Ishlinskii    x = x_0 + w_0 v + sum w_i y_i: plays of thresholds              m + 2
//     free start          the same; the plays y_i at the first sample are fitted too      2 m + 2
//   Preisach              x = x_0 + w_0 v + sum w_ij relay_ij[v]: model/preisach.h        N (N + 1) / 2 + 2
//
// All w >= 0. The number of parameters includes the fitted numbers, but not the evenly spaced thresholds.
//
// The history before the first sample is seldom known, and a wrong history makes a model look worse than it
// is. Each model with memory is therefore fitted after four histories, and the best fit is kept:
//
//   - the given prehistory, if there is one;
//   - none: the virgin state of the model at the first input (plays centred; on the ascending curve);
//   - up to range.hi, then down to range.lo;
//   - down to range.lo, then up to range.hi.
//
// The memory follows every sample. The fit uses about 5000 evenly chosen samples of weight > 0.
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
  std::vector<double> prehistory;  ///< inputs before the first sample, without outputs; may be empty
  std::vector<double> input;       ///< already delayed if the model has a delay
  std::vector<double> output;
  std::vector<double> weight;  ///< weight of the squared error; 0: held out, only predicted
  model::Interval range;       ///< thresholds of the identified model
  /// Called before each run over the samples; if it returns false, the fit throws Stopped. Empty: never
  /// stops.
  std::function<bool()> go_on{};
};

struct Stopped : std::runtime_error {
  Stopped() : std::runtime_error("stopped") {}
};

struct BaselineModel {
  std::string name;
  std::size_t parameters = 0;
  std::vector<double> prediction;  ///< for every sample, also for held-out ones
};

// All fits throw std::invalid_argument if the columns of the samples differ in length, if a number is not
// finite, if a weight is negative, if no weight is positive, or if the range is not lo < hi.

/// Fits a polynomial of this order, 0 to 32.
BaselineModel fit_average(const Samples& samples, std::size_t order);

/// Fits a Preisach model with this number of rows of cells, at least one. Widens the range to contain every
/// input.
BaselineModel fit_preisach(const Samples& samples, std::size_t levels);

/// Fits one baseline of fixed size. The identified model supplies orders and start values.
using FitBaseline =
    std::function<BaselineModel(const Samples&, const model::HysteresisParameters& identified)>;

/// The baselines of a report: average with the order of the ascending curve; linear mapping;
/// Prandtl-Ishlinskii with 9 plays, with 30 plays, and with 30 plays and a free start; Preisach with 20
/// levels.
const std::vector<FitBaseline>& every_baseline();

}  // namespace hystcan::identification
