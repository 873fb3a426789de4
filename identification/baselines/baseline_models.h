// Models to compare an identified one with, each fitted by least squares to the same samples.
//
//   average               x = p(v): one polynomial, no memory                            n + 1 parameters
//   linear mapping        model/linear_mapping.h: f_0^A, f_0^D of orders n and m          n + m + 1
//   Prandtl-Ishlinskii    x = x_0 + w_0 v + sum w_i y_i: plays of thresholds              m + 2
//                         r_i = i / (m + 1) of half the width of the inputs
//     free start          and the plays y_i at the first sample                           2 m + 2
//   Preisach              x = x_0 + w_0 v + sum w_ij relay_ij[v]: model/preisach.h       N (N + 1) / 2 + 2
//
// All w >= 0. Counted are the numbers fitted; thresholds that are placed evenly are not.
//
// What came before the first sample is seldom known, and a fixed start is a handicap: each model with memory
// is fitted from four histories, and the best is kept: the prehistory given (where there is one); none, at
// the first input; up to range.hi, then down to range.lo; down to range.lo, then up to range.hi. "None" is
// each model's own virgin state: plays centred; on the ascending curve.
//
// The memory follows every sample; fitted is to about 5000 samples of weight > 0, evenly chosen.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "model/hysteresis_parameters.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

struct Samples {
  std::span<const double> prehistory;  ///< inputs applied before the dataset, unobserved; may be empty
  std::span<const double> input;       ///< already delayed, where the dataset asks for it
  std::span<const double> output;
  std::span<const double> weight;  ///< of the squared error; 0: held out, predicted only
  model::Interval range;           ///< thresholds of the identified model
};

struct BaselineModel {
  std::string name;
  std::size_t parameters = 0;
  std::vector<double> prediction;  ///< of every sample, held out or not
};

// All of them throw std::invalid_argument where the samples' columns differ in length, hold a number that is
// not finite or a negative weight, no weight is positive, or range is not lo < hi.

/// Orders 0 to 32.
BaselineModel fit_average(const Samples& samples, std::size_t order);

/// Levenberg's method from the curves of `start`, whose orders and symmetry are kept, k playing no part. The
/// curves stay valid (model/validity.h), and rise everywhere with at least a thousandth of the mean slope.
/// Throws std::invalid_argument where the curves of `start` won't do.
BaselineModel fit_linear_mapping(const Samples& samples, const model::HysteresisParameters& start);

/// At least one play.
BaselineModel fit_prandtl_ishlinskii(const Samples& samples, std::size_t plays);

/// From the best of the histories on, Levenberg's method on weights and initial plays.
BaselineModel fit_prandtl_ishlinskii_free_start(const Samples& samples, std::size_t plays);

/// At least one level; the range is widened to hold every input.
BaselineModel fit_preisach(const Samples& samples, std::size_t levels);

/// One of them, its size fixed but for what it takes from the identified model.
using FitBaseline =
    std::function<BaselineModel(const Samples&, const model::HysteresisParameters& identified)>;

/// The table of a report: average of the order of the ascending curve, linear mapping, Prandtl-Ishlinskii of
/// 9 and 30 plays and of 30 with a free start, Preisach of 20 levels.
const std::vector<FitBaseline>& every_baseline();

}  // namespace hystcan::identification
