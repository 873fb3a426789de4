#include "config/files/model_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "config/files/model_schema.h"
#include "model/simplified.h"
#include "model/validity.h"

namespace hystcan::config {
namespace {

/// Turns an exception of `make` into an error at the key, or at the table.
template <class Make>
auto made(const Document& document, const std::string& key, Make make) {
  try {
    return make();
  } catch (const model::BranchError& error) {
    const bool up = error.direction == model::Direction::ascending;
    document.fail_at(up ? "hysteresis.k_ascending" : "hysteresis.k_descending", error.what());
  } catch (const std::invalid_argument& error) {
    document.fail_at(key, error.what());
  }
}

ModelFile read_model(const Document& document) {
  ModelFile raw;
  Reader reader(document, document.root(), "");
  visit_tables(reader, raw);
  reader.finish();
  if (!(raw.input_min < raw.input_max))
    document.fail_at("hysteresis.input_max",
                     fmt::format("input_max is {}, expected more than input_min, which is {}", raw.input_max,
                                 raw.input_min));
  if (raw.creep) made(document, "creep", [&] { model::OutputCreep(*raw.creep); });
  if (raw.symmetry == model::Symmetry::even && raw.input_min < 0.0)
    document.fail_at("hysteresis.input_min",
                     fmt::format("input_min is {}, expected >= 0 with symmetry \"even\": "
                                 "the model is folded to |input|",
                                 raw.input_min));
  return raw;
}

model::HysteresisParameters parameters(const Document& document, const ModelFile& raw) {
  const auto curve = [&](const char* key, const std::vector<double>& coefficients) {
    return made(document, std::string("hysteresis.") + key, [&]() -> model::ReferenceCurve {
      const model::Interval range{raw.input_min, raw.input_max};
      if (raw.basis == model::Basis::spline) return {model::CubicSpline(raw.knots, coefficients), range};
      return {raw.basis, coefficients, range};
    });
  };
  model::HysteresisParameters parameters{.input_unit = raw.input_unit,
                                         .output_unit = raw.output_unit,
                                         .ascending = curve("ascending", raw.ascending),
                                         .descending = curve("descending", raw.descending),
                                         .k_ascending = raw.k_ascending,
                                         .k_descending = raw.k_descending,
                                         .symmetry = raw.symmetry};
  if (!raw.input_map.empty())
    made(document, "hysteresis.input_map", [&] {
      parameters.input_map.emplace(raw.knots, raw.input_map);
      model::check_input_map(parameters);
    });
  if (!raw.output_map.empty())
    made(document, "hysteresis.output_map", [&] {
      parameters.output_map.emplace(raw.output_map, model::Interval{parameters.ascending.value(raw.input_min),
                                                                    parameters.upper_point().output});
    });
  return parameters;
}

model::AnyParameters any_parameters(const Document& document, const ModelFile& raw) {
  const model::Interval range{raw.input_min, raw.input_max};
  if (raw.kind == model::PrandtlIshlinskii::kind())
    return model::PrandtlIshlinskiiParameters{raw.input_unit, raw.output_unit, range,      raw.offset,
                                              raw.gain,       raw.thresholds,  raw.weights};
  if (raw.kind == model::Preisach::kind())
    return model::PreisachParameters{raw.input_unit, raw.output_unit, range,
                                     raw.offset,     raw.gain,        raw.weights};
  const model::HysteresisParameters given = parameters(document, raw);
  if (raw.kind == model::LinearMapping::kind()) return model::LinearMappingParameters{given};
  return raw.kind == average_kind ? model::average(given) : given;
}

/// Writes a model file: the keys in a column, the numbers to the bit.
class ModelWriter {
 public:
  template <class T>
  void required(std::string_view key, const T& value, Range = any, const About& about = {}) {
    if constexpr (std::is_floating_point_v<T>)
      line(key, fmt::format("{:.{}g}", value, about.digits), about.meaning);
    else if constexpr (std::is_integral_v<T>)
      line(key, fmt::format("{}", value), about.meaning);
    else if constexpr (IsVector<T>::value)
      line(key, fmt::format("[{:.17g}]", fmt::join(value, ", ")), about.meaning);
    else
      line(key, fmt::format("\"{}\"", value), about.meaning);
  }
  void numbers(std::string_view key, const std::vector<double>& values) {
    if (!values.empty()) required(key, values);
  }
  void choice(std::string_view key, const std::string& value, std::span<const std::string_view>) {
    required(key, value);
  }
  template <HasWords Enum>
  void choice(std::string_view key, Enum value) {
    required(key, word_of(value));
  }
  template <class T, class Visit>
  void table(std::string_view key, T& value, Visit visit) {
    text_ += fmt::format("{}[{}]\n", text_.empty() ? "" : "\n", key);
    visit(*this, value);
  }

  template <class T, class Visit>
  void optional_table(std::string_view key, std::optional<T>& value, Visit visit) {
    if (value) table(key, *value, visit);
  }

  const std::string& text() const { return text_; }

 private:
  void line(std::string_view key, const std::string& value, std::string_view remark) {
    text_ += fmt::format("{:<12} = {}{}{}\n", key, value, remark.empty() ? "" : "  # ", remark);
  }

  std::string text_;
};

// Reads the kind first, because the keys depend on it.
model::HysteresisParameters recursive_memory(const Document& document) {
  const auto kind = document.root().at_path("hysteresis.kind").value<std::string>();
  if (kind && *kind != model::Hysteresis::kind())
    document.fail_at("hysteresis.kind",
                     fmt::format("kind is \"{}\", expected \"recursive-memory\" here", *kind));
  return parameters(document, read_model(document));
}

}  // namespace

bool is_model_file(const std::filesystem::path& file) {
  return Document(file, {}, largest_model_file).root().contains("hysteresis");
}

model::AnyModel load_any_model(const std::filesystem::path& file) {
  const Document document(file, {}, largest_model_file);
  const ModelFile raw = read_model(document);
  return made(document, "hysteresis", [&] { return model::model_of(any_parameters(document, raw)); });
}

model::AnyParameters load_any_parameters(const std::filesystem::path& file) {
  const Document document(file, {}, largest_model_file);
  model::AnyParameters given = any_parameters(document, read_model(document));
  made(document, "hysteresis", [&] { return model::model_of(given); });
  return given;
}

model::HysteresisParameters load_model(const std::filesystem::path& file) {
  const Document document(file, {}, largest_model_file);
  const model::HysteresisParameters given = recursive_memory(document);
  return made(document, "hysteresis", [&] { return model::Hysteresis(given).parameters(); });
}

std::string model_text(const model::HysteresisParameters& parameters,
                       const std::optional<IdentifiedFrom>& from,
                       const std::optional<model::Dynamics>& dynamics,
                       const std::optional<model::OutputCreep::Config>& creep) {
  const model::Interval& range = parameters.input_range();
  ModelFile raw{.identified_from = from,
                .creep = creep,
                .dynamics = dynamics,
                .kind = std::string(model::Hysteresis::kind()),
                .input_unit = parameters.input_unit,
                .output_unit = parameters.output_unit,
                .input_min = range.lo,
                .input_max = range.hi,
                .basis = parameters.ascending.basis(),
                .knots = parameters.ascending.knots(),
                .ascending = parameters.ascending.coefficients(),
                .descending = parameters.descending.coefficients(),
                .input_map = {},
                .output_map = {},
                .k_ascending = parameters.k_ascending,
                .k_descending = parameters.k_descending,
                .symmetry = parameters.symmetry,
                .thresholds = {},
                .weights = {}};
  if (parameters.input_map) raw.input_map = parameters.input_map->coefficients();
  if (parameters.output_map) raw.output_map = parameters.output_map->coefficients();
  ModelWriter writer;
  visit_tables(writer, raw);
  return writer.text();
}

IdentifiedFrom load_identified_from(const std::filesystem::path& file) {
  return read_model(Document(file, {}, largest_model_file)).identified_from.value_or(IdentifiedFrom{});
}

std::optional<model::Dynamics> load_dynamics(const std::filesystem::path& file) {
  return read_model(Document(file, {}, largest_model_file)).dynamics;
}

identification::Lag load_lag(const std::filesystem::path& file) {
  const ModelFile raw = read_model(Document(file, {}, largest_model_file));
  return {raw.identified_from ? raw.identified_from->delay_s : 0.0, raw.dynamics, raw.creep};
}

std::optional<model::OutputCreep::Config> load_creep(const std::filesystem::path& file) {
  return read_model(Document(file, {}, largest_model_file)).creep;
}

model::Hysteresis load_model_beyond_limit(const std::filesystem::path& file) {
  const Document document(file, {}, largest_model_file);
  const model::HysteresisParameters given = recursive_memory(document);
  return made(document, "hysteresis", [&] { return model::Hysteresis::beyond_limit(given); });
}

}  // namespace hystcan::config
