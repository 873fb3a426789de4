#include "model/any_model.h"

namespace hystcan::model {
namespace {

const HysteresisParameters& plain(const HysteresisParameters& parameters) { return parameters; }
const HysteresisParameters& plain(const LinearMappingParameters& parameters) { return parameters.curves; }
const PrandtlIshlinskiiParameters& plain(const PrandtlIshlinskiiParameters& parameters) { return parameters; }
const PreisachParameters& plain(const PreisachParameters& parameters) { return parameters; }

const Interval& range_of(const HysteresisParameters& parameters) { return parameters.input_range(); }
template <class Parameters>
const Interval& range_of(const Parameters& parameters) {
  return parameters.input_range;
}

Hysteresis make(const HysteresisParameters& parameters) { return Hysteresis(parameters); }
LinearMapping make(const LinearMappingParameters& parameters) { return LinearMapping(parameters.curves); }
PrandtlIshlinskii make(const PrandtlIshlinskiiParameters& parameters) {
  return PrandtlIshlinskii(parameters);
}
Preisach make(const PreisachParameters& parameters) { return Preisach(parameters); }

}  // namespace

AnyModel model_of(const AnyParameters& parameters) {
  return std::visit([](const auto& one) { return AnyModel(make(one)); }, parameters);
}

const std::string& input_unit(const AnyParameters& parameters) {
  return std::visit([](const auto& one) -> const std::string& { return plain(one).input_unit; }, parameters);
}

const std::string& output_unit(const AnyParameters& parameters) {
  return std::visit([](const auto& one) -> const std::string& { return plain(one).output_unit; }, parameters);
}

const Interval& input_range(const AnyParameters& parameters) {
  return std::visit([](const auto& one) -> const Interval& { return range_of(plain(one)); }, parameters);
}

}  // namespace hystcan::model
