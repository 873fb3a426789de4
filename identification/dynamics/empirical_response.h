// The frequency response of a dataset without a model, by Welch's method.
//
//   H(f) = S_uy / S_uu,   coherence = |S_uy|^2 / (S_uu S_yy),   S_ab = sum over segments of conj(A) B
//
// A, B are the discrete Fourier transforms of half-overlapping segments under a Hann window, of the
// differences from cycle to cycle. The differences have the same quotient, and they turn steps into impulses,
// which excite all frequencies equally. H relates the drive at a row's time to the output of the same row, as
// in identification/dynamics/second_order_fit.h. In a cycle without a row, the drive is held and the output
// is a straight line.
#pragma once

#include <complex>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::identification {

struct ResponsePoint {
  double frequency_Hz = 0.0;
  std::complex<double> response;  ///< output unit per input unit
  double coherence = 0.0;         ///< 0 to 1: share of the output that follows the input
};

/// Returns the response at ascending frequencies, without those that the drive does not excite. Empty if the
/// dataset has too few rows. Throws std::invalid_argument if the dataset is not evenly sampled
/// (identification/dynamics/sampled_dataset.h).
std::vector<ResponsePoint> empirical_response(const Dataset& dataset);

}  // namespace hystcan::identification
