// Amplitude spectral density (ASD) of a signal by Welch's method. The signal is divided into segments of N
// samples, N = `length`, which overlap by half. The mean of each segment is removed, and the segment is
// multiplied by a Hann window w. X(f) is its discrete Fourier transform. The one-sided power densities of all
// segments are averaged:
//
//   ASD(f) = sqrt( mean of 2 |X(f)|^2 / (rate * sum w^2) )      at f = rate/2 without the factor 2
//   sum over f of ASD(f)^2 * rate / N = variance of the signal
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
  /// `rate_Hz`: sampling rate. `length`: samples in a segment, an even number.
  explicit Spectrum(double rate_Hz, std::size_t length = 1024);

  void add(double value);
  /// Discards the incomplete segment and starts a new one. Call it if samples are missing before the next
  /// value.
  void break_off() { segment_.clear(); }

  std::size_t segments() const { return segments_; }
  /// Returns the frequencies of the spectrum: rate/length, 2 rate/length, ..., rate/2 (rate: sampling rate,
  /// length: samples in a segment).
  std::vector<double> frequencies_Hz() const;
  /// Returns the amplitude spectral density at each of frequencies_Hz(), in signal units per sqrt(Hz). Empty
  /// if no segment is complete.
  std::vector<double> densities() const;

 private:
  void take_segment();

  double rate_Hz_;
  model::HannTransform transform_;
  std::vector<double> segment_;
  std::vector<double> powers_;  ///< power at each frequency, summed over all segments
  std::size_t segments_ = 0;
};

}  // namespace hystcan::metrics
