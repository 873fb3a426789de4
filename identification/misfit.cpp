#include "identification/misfit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "identification/identify.h"
#include "model/spectrum.h"

namespace hystcan::identification {
namespace {

constexpr std::size_t longest_segment = 32768;
constexpr std::size_t most_octaves = 24;

double travelled(const Dataset& dataset) {
  double distance = 0.0;
  for (std::size_t i = 1; i < dataset.size(); ++i)
    distance += std::abs(dataset.input[i] - dataset.input[i - 1]);
  return distance;
}

std::vector<double> residual_of(const Identified& identified, const std::vector<Dataset>& datasets,
                                std::size_t i) {
  std::vector<double> residual = predict(identified, datasets, i);
  double mean = 0.0;
  for (std::size_t j = 0; j < residual.size(); ++j) {
    residual[j] = datasets[i].output[j] - residual[j];
    mean += residual[j] / static_cast<double>(residual.size());
  }
  for (double& of : residual) of -= mean;
  return residual;
}

/// Adds the squared spectrum of one record's residual to `squares`, which has one sum for each octave. The
/// first octave starts at `lowest`, in periods per input unit. `distance` is the distance that the input
/// travels in the record, in input units.
void add(const std::vector<double>& residual, double distance, double lowest, std::vector<double>& squares) {
  const std::size_t length = std::min(residual.size() / 2 * 2, longest_segment);
  if (length < 4 || !(distance > 0.0)) return;
  const model::HannTransform transform(length);
  const double part = distance * static_cast<double>(length) / static_cast<double>(residual.size());
  for (std::size_t first = 0; first + length <= residual.size(); first += length / 2) {
    const auto spectrum = transform(std::span(residual).subspan(first, length));
    for (std::size_t k = 1; k < spectrum.size(); ++k) {
      const double octave = std::log2(static_cast<double>(k) / part / lowest);
      const auto place = static_cast<std::size_t>(
          std::clamp(std::floor(octave), 0.0, static_cast<double>(most_octaves - 1)));
      squares[place] += std::norm(spectrum[k]) / static_cast<double>(length);
    }
  }
}

}  // namespace

double Misfit::middle(std::size_t octave) const {
  return lowest * std::exp2(static_cast<double>(octave)) * std::numbers::sqrt2;
}

Misfit misfit_of(const Identified& identified, const std::vector<Dataset>& datasets) {
  double longest = 0.0, noise = 0.0, distance = 0.0, time_s = 0.0;
  for (const Dataset& dataset : datasets) {
    longest = std::max(longest, travelled(dataset));
    distance += travelled(dataset);
    time_s += dataset.time_s.back() - dataset.time_s.front();
  }
  for (const Characterisation& is : identified.datasets) noise = std::max(noise, is.noise);
  Misfit misfit{.speed = distance / time_s, .lowest = 1.0 / longest, .rms = {}};
  std::vector<double> squares(most_octaves, 0.0);
  for (std::size_t i = 0; i < datasets.size(); ++i)
    add(residual_of(identified, datasets, i), travelled(datasets[i]), misfit.lowest, squares);
  while (!squares.empty() && squares.back() == 0.0) squares.pop_back();
  double sum = 0.0;
  for (const double square : squares) sum += square;
  const double error = identified.held_out_rms.value_or(identified.overall.rms);
  const double whole = std::max(0.0, error * error - noise * noise);
  for (const double square : squares) misfit.rms.push_back(std::sqrt(square / sum * whole));
  return misfit;
}

}  // namespace hystcan::identification
