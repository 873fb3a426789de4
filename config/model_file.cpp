#include <fmt/format.h>

#include "config/schema.h"

namespace hystcan::config {

model::HysteresisParameters load_model(const std::filesystem::path& file) {
  const Document document(file);
  ModelFile raw;
  Reader reader(document, document.root(), "");
  reader.table("hysteresis", raw, [](Reader& sub, ModelFile& value) { visit(sub, value); });
  reader.finish();

  const auto basis = raw.basis == "power" ? model::Basis::power : model::Basis::chebyshev;
  const model::Interval range{raw.input_min, raw.input_max};
  if (!(range.lo < range.hi))
    document.fail_at(
        "hysteresis.input_max",
        fmt::format("input_max is {}, expected more than input_min, which is {}", range.hi, range.lo));
  if (raw.symmetry == "even" && range.lo < 0.0)
    document.fail_at("hysteresis.input_min",
                     fmt::format("input_min is {}, expected >= 0 with symmetry \"even\": "
                                 "the model is folded to |input|",
                                 range.lo));
  const auto curve = [&](const char* key, const std::vector<double>& coefficients) {
    try {
      return model::ReferenceCurve(basis, coefficients, range);
    } catch (const std::invalid_argument& error) {
      document.fail_at(std::string("hysteresis.") + key, error.what());
    }
  };
  model::HysteresisParameters parameters{
      .input_unit = raw.input_unit,
      .output_unit = raw.output_unit,
      .ascending = curve("ascending", raw.ascending),
      .descending = curve("descending", raw.descending),
      .k_ascending = raw.k_ascending,
      .k_descending = raw.k_descending,
      .symmetry = raw.symmetry == "even" ? model::Symmetry::even : model::Symmetry::none};
  try {
    model::Hysteresis checked(parameters);
  } catch (const std::invalid_argument& error) {
    document.fail_at("hysteresis", error.what());
  }
  return parameters;
}

}  // namespace hystcan::config
