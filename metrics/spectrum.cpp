#include "metrics/spectrum.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>

namespace hystcan::metrics {

Spectrum::Spectrum(double rate_Hz, std::size_t length)
    : rate_Hz_(rate_Hz), length_(length), window_(length), powers_(length / 2) {
  for (std::size_t i = 0; i < length; ++i)
    window_[i] =
        0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(length));
}

void Spectrum::add(double value) {
  segment_.push_back(value);
  if (segment_.size() == length_) take_segment();
}

void Spectrum::take_segment() {
  const double mean = std::reduce(segment_.begin(), segment_.end()) / static_cast<double>(length_);
  std::vector<double> windowed(length_);
  for (std::size_t i = 0; i < length_; ++i) windowed[i] = (segment_[i] - mean) * window_[i];
  std::vector<std::complex<double>> transform;
  Eigen::FFT<double> fft;
  fft.fwd(transform, windowed);
  for (std::size_t i = 0; i < powers_.size(); ++i)
    powers_[i] += (i + 1 == length_ / 2 ? 1.0 : 2.0) * std::norm(transform[i + 1]);
  segment_.erase(segment_.begin(), segment_.begin() + static_cast<std::ptrdiff_t>(length_ / 2));
  ++segments_;
}

std::vector<double> Spectrum::frequencies_Hz() const {
  std::vector<double> frequencies(powers_.size());
  for (std::size_t i = 0; i < frequencies.size(); ++i)
    frequencies[i] = rate_Hz_ * static_cast<double>(i + 1) / static_cast<double>(length_);
  return frequencies;
}

std::vector<double> Spectrum::densities() const {
  if (segments_ == 0) return {};
  const double weight = std::inner_product(window_.begin(), window_.end(), window_.begin(), 0.0);
  std::vector<double> densities(powers_.size());
  for (std::size_t i = 0; i < densities.size(); ++i)
    densities[i] = std::sqrt(powers_[i] / (static_cast<double>(segments_) * rate_Hz_ * weight));
  return densities;
}

}  // namespace hystcan::metrics
