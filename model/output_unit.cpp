#include "model/output_unit.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace hystcan::model {
namespace {

std::vector<double> times(std::vector<double> numbers, double factor) {
  for (double& number : numbers) number *= factor;
  return numbers;
}

void scale(HysteresisParameters& p, double factor) {
  p.output_unit = "um";
  if (p.output_map) {
    p.output_map.emplace(times(p.output_map->coefficients(), factor), p.output_map->inner());
    return;
  }
  p.ascending = p.ascending.with(times(p.ascending.coefficients(), factor));
  p.descending = p.descending.with(times(p.descending.coefficients(), factor));
}

void scale(LinearMappingParameters& p, double factor) { scale(p.curves, factor); }

template <class Operators>
void scale(Operators& p, double factor) {
  p.offset *= factor;
  p.gain *= factor;
  p.weights = times(std::move(p.weights), factor);
  p.output_unit = "um";
}

}  // namespace

std::optional<double> length_um(std::string_view unit) {
  constexpr std::array<std::pair<std::string_view, double>, 6> lengths{
      {{"nm", 1e-3}, {"um", 1.0}, {"\u00b5m", 1.0}, {"\u03bcm", 1.0}, {"mm", 1e3}, {"m", 1e6}}};
  for (const auto& [name, um] : lengths)
    if (unit == name) return um;
  return std::nullopt;
}

AnyParameters in_um(AnyParameters parameters) {
  const auto factor = length_um(output_unit(parameters));
  if (factor && output_unit(parameters) != "um")
    std::visit([&](auto& one) { scale(one, *factor); }, parameters);
  return parameters;
}

}  // namespace hystcan::model
