#include "config/files/model_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <string_view>
#include <vector>

#include "config/document/document.h"
#include "config/document/format.h"
#include "model/hysteresis_parameters.h"
#include "model/validity.h"

namespace hystcan::config {
namespace {

/// The average model is a recursive-memory model whose two reference curves are replaced by their mean. Its
/// file has no k_ascending and k_descending. Only model files have the kind "average": the loaded model is a
/// model::Hysteresis with two equal curves.
constexpr std::string_view average_kind = "average";

constexpr std::array<std::string_view, 5> model_kinds{
    model::Hysteresis::kind(), average_kind, model::LinearMapping::kind(), model::PrandtlIshlinskii::kind(),
    model::Preisach::kind()};

/// The content of a model file, all tables. Which keys [hysteresis] has depends on the kind of model.
struct ModelTables {
  std::optional<IdentifiedFrom> identified_from;
  std::optional<model::OutputCreep::Config> creep{};
  std::optional<model::Dynamics> dynamics{};
  std::string kind;
  std::string input_unit;
  std::string output_unit;
  double input_min = 0.0;
  double input_max = 0.0;
  model::Basis basis = model::Basis::chebyshev;
  std::vector<double> knots;
  std::vector<double> ascending;
  std::vector<double> descending;
  std::vector<double> input_map{};
  std::vector<double> output_map{};
  double k_ascending = 0.0;
  double k_descending = 0.0;
  model::Symmetry symmetry = model::Symmetry::none;
  double offset = 0.0;
  double gain = 0.0;
  std::vector<double> thresholds{};
  std::vector<double> weights{};
};

template <class V>
void visit(V& v, ModelTables& m) {
  v.choice("kind", m.kind, model_kinds);
  v.required("input_unit", m.input_unit);
  v.required("output_unit", m.output_unit);
  v.required("input_min", m.input_min);
  v.required("input_max", m.input_max);
  const bool has_thresholds = m.kind == model::PrandtlIshlinskii::kind();
  if (has_thresholds || m.kind == model::Preisach::kind()) {
    v.required("offset", m.offset);
    v.required("gain", m.gain);
    if (has_thresholds) v.required("thresholds", m.thresholds);
    v.required("weights", m.weights);
    return;
  }
  v.required("basis", m.basis);
  if (m.basis == model::Basis::spline) v.required("knots", m.knots);
  v.required("ascending", m.ascending);
  v.required("descending", m.descending);
  if (m.kind == model::Hysteresis::kind()) {
    v.required("k_ascending", m.k_ascending);
    v.required("k_descending", m.k_descending);
    if (m.basis == model::Basis::spline) v.optional("input_map", m.input_map);
  }
  if (m.kind == model::Hysteresis::kind() || m.kind == average_kind) v.optional("output_map", m.output_map);
  v.required("symmetry", m.symmetry);
}

template <class V>
void visit(V& v, identification::Misfit& misfit) {
  v.required("speed", misfit.speed, positive, {.meaning = "input units per second", .digits = 4});
  v.required("lowest", misfit.lowest, positive, {.meaning = "per input unit", .digits = 4});
  v.optional(
      "rms", misfit.rms, any,
      {.meaning = "RMS error of the model in each octave above the frequency `lowest`, in output units"});
}

template <class V>
void visit(V& v, IdentifiedFrom& from) {
  v.required("samples", from.samples, {.lo = 1.0});
  v.required("delay_s", from.delay_s, not_negative, {.meaning = "delay of the output behind the input"});
  v.required("rms_percent", from.rms_percent, not_negative,
             {.meaning = "RMS error, relative to the output span of the dataset", .digits = 4});
  v.required("max_percent", from.max_percent, not_negative, {.digits = 4});
  v.optional_table("misfit", from.misfit, [](V& sub, auto& value) { visit(sub, value); });
}

template <class V>
void visit(V& v, model::Dynamics& d) {
  v.required("resonance_Hz", d.mode.natural_frequency_Hz, positive);
  v.required("damping_ratio", d.mode.damping_ratio, not_negative);
  v.required("delay_s", d.delay_s, not_negative);
}

template <class V>
void visit(V& v, model::OutputCreep::Config& c) {
  v.required("per_decade", c.per_decade, {.lo = -0.1, .hi = 0.2}, {.meaning = "share of the output"});
  v.required("from_s", c.from_s, positive);
  v.required("to_s", c.to_s, positive);
}

template <class V>
void visit_tables(V& v, ModelTables& m) {
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.table("hysteresis", m, plain);
  v.optional_table("creep", m.creep, plain);
  v.optional_table("dynamics", m.dynamics, plain);
  v.optional_table("identification", m.identified_from, plain);
}

/// Returns the result of `make`. If `make` throws because a parameter is invalid, throws Error with the place
/// of `key` in the file.
template <class Make>
auto made(const Document& document, const std::string& key, Make make) {
  try {
    return make();
  } catch (const model::BranchError& error) {
    const bool up = error.direction == model::Direction::ascending;
    throw Error(document.place_at(up ? "hysteresis.k_ascending" : "hysteresis.k_descending"), error);
  } catch (const std::invalid_argument& error) {
    throw Error(document.place_at(key), error);
  }
}

ModelTables read_model(const Document& document) {
  ModelTables raw;
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
                                 "the model depends only on |input|",
                                 raw.input_min));
  return raw;
}

model::HysteresisParameters parameters(const Document& document, const ModelTables& raw) {
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
                                                                    parameters.upper_point().level});
    });
  return parameters;
}

model::AnyParameters any_parameters(const Document& document, const ModelTables& raw) {
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

// Reads a model that must be of the kind recursive-memory. Checks the kind first, because the keys depend on
// it.
model::HysteresisParameters recursive_memory(const Document& document) {
  const auto kind = document.root().at_path("hysteresis.kind").value<std::string>();
  if (kind && *kind != model::Hysteresis::kind())
    document.fail_at(
        "hysteresis.kind",
        fmt::format("kind is \"{}\", expected \"recursive-memory\": this command reads no other kind",
                    *kind));
  return parameters(document, read_model(document));
}

}  // namespace

bool is_model_file(const std::filesystem::path& file) {
  return Document(file, largest_model_file).root().contains("hysteresis");
}

model::AnyModel load_any_model(const std::filesystem::path& file) {
  const Document document(file, largest_model_file);
  const ModelTables raw = read_model(document);
  return made(document, "hysteresis", [&] { return model::model_of(any_parameters(document, raw)); });
}

model::AnyParameters load_any_parameters(const std::filesystem::path& file) {
  const Document document(file, largest_model_file);
  model::AnyParameters given = any_parameters(document, read_model(document));
  made(document, "hysteresis", [&] { return model::model_of(given); });
  return given;
}

model::HysteresisParameters load_model(const std::filesystem::path& file) {
  const Document document(file, largest_model_file);
  const model::HysteresisParameters given = recursive_memory(document);
  return made(document, "hysteresis", [&] { return model::Hysteresis(given).parameters(); });
}

std::string model_text(const model::HysteresisParameters& parameters,
                       const std::optional<IdentifiedFrom>& from,
                       const std::optional<model::Dynamics>& dynamics,
                       const std::optional<model::OutputCreep::Config>& creep) {
  const model::Interval& range = parameters.input_range();
  ModelTables raw{.identified_from = from,
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
                  .k_ascending = parameters.k_ascending,
                  .k_descending = parameters.k_descending,
                  .symmetry = parameters.symmetry};
  if (parameters.input_map) raw.input_map = parameters.input_map->coefficients();
  if (parameters.output_map) raw.output_map = parameters.output_map->coefficients();
  Writer writer(Writer::Layout::model, [](const Setting& key, bool /*is_required*/) {
    return key.value == "[]" ? std::nullopt : std::optional<std::string>("");
  });
  visit_tables(writer, raw);
  return fmt::format("{}{}", format_line, writer.text());  // writer.text() begins with an empty line
}

identification::Lag load_lag(const std::filesystem::path& file) {
  const ModelTables raw = read_model(Document(file, largest_model_file));
  return {raw.identified_from ? raw.identified_from->delay_s : 0.0, raw.dynamics, raw.creep};
}

std::optional<identification::Misfit> load_misfit(const std::filesystem::path& file) {
  const ModelTables raw = read_model(Document(file, largest_model_file));
  std::optional<identification::Misfit> misfit;
  if (raw.identified_from) misfit = raw.identified_from->misfit;
  if (const auto factor = model::length_um(raw.output_unit); misfit && factor)
    for (double& of : misfit->rms) of *= *factor;
  return misfit;
}

model::Hysteresis load_model_beyond_limit(const std::filesystem::path& file) {
  const Document document(file, largest_model_file);
  const model::HysteresisParameters given = recursive_memory(document);
  return made(document, "hysteresis", [&] { return model::Hysteresis::beyond_limit(given); });
}

}  // namespace hystcan::config
