#include "model/any_model.h"

#include <array>
#include <type_traits>
#include <utility>
#include <vector>

namespace hystcan::model {
namespace {

template <class Parameters>
constexpr bool has_curves = std::is_base_of_v<HysteresisParameters, Parameters>;

std::vector<double> times(std::vector<double> numbers, double factor) {
  for (double& number : numbers) number *= factor;
  return numbers;
}

void scale_output(HysteresisParameters& p, double factor) {
  if (p.output_map) {
    p.output_map.emplace(times(p.output_map->coefficients(), factor), p.output_map->inner());
    return;
  }
  p.ascending = p.ascending.with(times(p.ascending.coefficients(), factor));
  p.descending = p.descending.with(times(p.descending.coefficients(), factor));
}

template <class Operators>
requires(!has_curves<Operators>) void scale_output(Operators& p, double factor) {
  p.offset *= factor;
  p.gain *= factor;
  p.weights = times(std::move(p.weights), factor);
}

Hysteresis made(const HysteresisParameters& parameters) { return Hysteresis(parameters); }
LinearMapping made(const LinearMappingParameters& parameters) { return LinearMapping(parameters); }
PrandtlIshlinskii made(const PrandtlIshlinskiiParameters& parameters) {
  return PrandtlIshlinskii(parameters);
}
Preisach made(const PreisachParameters& parameters) { return Preisach(parameters); }

}  // namespace

AnyModel model_of(const AnyParameters& parameters) {
  return std::visit([](const auto& one) { return AnyModel(made(one)); }, parameters);
}

const std::string& input_unit(const AnyParameters& parameters) {
  return std::visit([](const auto& one) -> const std::string& { return one.input_unit; }, parameters);
}

const std::string& output_unit(const AnyParameters& parameters) {
  return std::visit([](const auto& one) -> const std::string& { return one.output_unit; }, parameters);
}

const Interval& input_range(const AnyParameters& parameters) {
  const auto range = []<class Parameters>(const Parameters& one) -> const Interval& {
    if constexpr (has_curves<Parameters>)
      return one.input_range();
    else
      return one.input_range;
  };
  return std::visit(range, parameters);
}

std::optional<double> length_um(std::string_view unit) {
  constexpr std::array<std::pair<std::string_view, double>, 6> lengths{
      {{"nm", 1e-3}, {"um", 1.0}, {"\u00b5m", 1.0}, {"\u03bcm", 1.0}, {"mm", 1e3}, {"m", 1e6}}};
  for (const auto& [name, um] : lengths)
    if (unit == name) return um;
  return std::nullopt;
}

AnyParameters in_um(AnyParameters parameters) {
  const auto factor = length_um(output_unit(parameters));
  if (!factor || output_unit(parameters) == "um") return parameters;
  const auto convert = [&](auto& one) {
    scale_output(one, *factor);
    one.output_unit = "um";
  };
  std::visit(convert, parameters);
  return parameters;
}

}  // namespace hystcan::model
