// Computes the frequency response of a dataset without a model, by Welch's method.
//
//   H(f) = S_uy / S_uu,   coherence = |S_uy|^2 / (S_uu S_yy),   S_ab = sum over segments of conj(A) B
//
//   u, y   input and output of the dataset, as differences from cycle to cycle
//   a, b   each of them u or y
//   A, B   discrete Fourier transforms of a and b: half-overlapping segments under a Hann window
//   H(f)   frequency response at the frequency f
//
// The differences have the same quotient as the signals themselves. They turn steps into impulses, which
// excite all frequencies equally. H relates the drive at the time of a row to the output of the same row, as
// in identification/dynamics/second_order_fit.h. In a cycle without a row, the drive keeps its value, and the
// output is interpolated linearly.
#pragma once

#include <complex>
#include <vector>

#include "identification/dataset.h"

namespace hystcan::identification {

struct ResponsePoint {
  double frequency_Hz = 0.0;
  std::complex<double> response;  ///< frequency response H(f), output units per input unit
  double coherence = 0.0;         ///< share of the output that follows the input, 0 to 1
};

/// Returns the response at ascending frequencies; frequencies that the drive does not excite are left out.
/// Empty if the dataset has too few rows. Throws std::invalid_argument if the dataset is not evenly sampled
/// (grid_of() in identification/quasi_static.h).
std::vector<ResponsePoint> empirical_response(const Dataset& dataset);

}  // namespace hystcan::identification
