// Discrete Fourier transform of a segment of a signal under a Hann window, for spectra by Welch's method.
//
//   X_k = sum_n w_n x_n e^{-2 pi i k n / N},     w_n = (1 - cos(2 pi n / N)) / 2,     k = 0 ... N/2
//
//   x_n, N   samples of the segment and their number
//   w_n      Hann window
//   X_k      transform at k / N of the sampling rate
//
// P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Trans. Audio
// Electroacoust. 15, 1967.
#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace hystcan::model {

class HannTransform {
 public:
  /// `length`: number of samples in a segment; must be even.
  explicit HannTransform(std::size_t length);

  std::size_t length() const { return window_.size(); }
  /// The Hann window: a weight for each sample.
  const std::vector<double>& window() const { return window_; }
  /// Returns the Fourier transform of a segment under the window, from frequency 0 to half the sampling rate.
  /// The segment must have length() samples.
  std::vector<std::complex<double>> operator()(std::span<const double> segment) const;

 private:
  std::vector<double> window_;
};

}  // namespace hystcan::model
