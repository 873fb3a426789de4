#include "metrics/spectrum.h"

#include <cmath>
#include <complex>
#include <numeric>

namespace hystcan::metrics {

Spectrum::Spectrum(double rate_Hz, std::size_t length)
    : rate_Hz_(rate_Hz), transform_(length), powers_(length / 2) {}

void Spectrum::add(double value) {
  segment_.push_back(value);
  if (segment_.size() == transform_.length()) take_segment();
}

void Spectrum::take_segment() {
  const std::size_t length = transform_.length();
  const double mean = std::reduce(segment_.begin(), segment_.end()) / static_cast<double>(length);
  std::vector<double> deviations(segment_);
  for (double& value : deviations) value -= mean;
  const std::vector<std::complex<double>> transform = transform_(deviations);
  for (std::size_t i = 0; i < powers_.size(); ++i)
    powers_[i] += (i + 1 == length / 2 ? 1.0 : 2.0) * std::norm(transform[i + 1]);
  segment_.erase(segment_.begin(), segment_.begin() + static_cast<std::ptrdiff_t>(length / 2));
  ++segments_;
}

std::vector<double> Spectrum::frequencies_Hz() const {
  std::vector<double> frequencies(powers_.size());
  for (std::size_t i = 0; i < frequencies.size(); ++i)
    frequencies[i] = rate_Hz_ * static_cast<double>(i + 1) / static_cast<double>(transform_.length());
  return frequencies;
}

std::vector<double> Spectrum::densities() const {
  if (segments_ == 0) return {};
  const std::vector<double>& window = transform_.window();
  const double weight = std::inner_product(window.begin(), window.end(), window.begin(), 0.0);
  std::vector<double> densities(powers_.size());
  for (std::size_t i = 0; i < densities.size(); ++i)
    densities[i] = std::sqrt(powers_[i] / (static_cast<double>(segments_) * rate_Hz_ * weight));
  return densities;
}

}  // namespace hystcan::metrics
