#include "model/spectrum.h"

#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace hystcan::model {

HannTransform::HannTransform(std::size_t length) : window_(length) {
  for (std::size_t n = 0; n < length; ++n)
    window_[n] =
        0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(n) / static_cast<double>(length));
}

std::vector<std::complex<double>> HannTransform::operator()(std::span<const double> segment) const {
  std::vector<double> windowed(window_);
  for (std::size_t n = 0; n < windowed.size(); ++n) windowed[n] *= segment[n];
  Eigen::FFT<double> transform;
  transform.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  std::vector<std::complex<double>> spectrum;
  transform.fwd(spectrum, windowed);
  return spectrum;
}

}  // namespace hystcan::model
