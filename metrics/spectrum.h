// Amplitude spectral density of a signal by Welch's method: segments of `length` samples that overlap by
// half, with the mean removed, under a Hann window; the one-sided power densities are averaged.
//
//   ASD(f) = sqrt( 2 |X(f)|^2 / (rate * sum w^2) ),   sum over f of ASD^2 * rate/length = variance
//
// P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Trans. Audio
// Electroacoust. 15, 1967.
#pragma once

#include <cstddef>
#include <vector>

#include "model/spectrum.h"

namespace hystcan::metrics {

class Spectrum {
 public:
  /// `length` must be even.
  explicit Spectrum(double rate_Hz, std::size_t length = 1024);

  void add(double value);
  /// Starts a new segment: values are missing between the last value and the next one.
  void break_off() { segment_.clear(); }

  std::size_t segments() const { return segments_; }
  /// Returns rate/length, 2 rate/length, ..., rate/2.
  std::vector<double> frequencies_Hz() const;
  /// Returns the density at each of frequencies_Hz(), in signal units per sqrt(Hz); empty if no segment is
  /// complete.
  std::vector<double> densities() const;

 private:
  void take_segment();

  double rate_Hz_;
  model::HannTransform transform_;
  std::vector<double> segment_;
  std::vector<double> powers_;  ///< sums over all segments
  std::size_t segments_ = 0;
};

}  // namespace hystcan::metrics
