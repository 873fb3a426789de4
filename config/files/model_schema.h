// The keys of model and memory files: one `visit` for each struct, both to read and to print it.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/document/document.h"
#include "config/files/model_file.h"

namespace hystcan::config {

/// The average model is a recursive-memory model without k. Only a file names it as a kind of its own.
inline constexpr std::string_view average_kind = "average";

inline constexpr std::array<std::string_view, 5> model_kinds{
    model::Hysteresis::kind(), average_kind, model::LinearMapping::kind(), model::PrandtlIshlinskii::kind(),
    model::Preisach::kind()};
inline constexpr std::array<std::string_view, 4> memory_kinds{
    model::Hysteresis::kind(), model::LinearMapping::kind(), model::PrandtlIshlinskii::kind(),
    model::Preisach::kind()};

/// [hysteresis] of a model file. The keys depend on the kind.
struct ModelFile {
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
  std::vector<double> input_map;
  std::vector<double> output_map;
  double k_ascending = 0.0;
  double k_descending = 0.0;
  model::Symmetry symmetry = model::Symmetry::none;
  double offset = 0.0;
  double gain = 0.0;
  std::vector<double> thresholds;
  std::vector<double> weights;
};

template <class V>
void visit(V& v, ModelFile& m) {
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
  v.choice("basis", m.basis);
  if (m.basis == model::Basis::spline) v.required("knots", m.knots);
  v.required("ascending", m.ascending);
  v.required("descending", m.descending);
  if (m.kind == model::Hysteresis::kind()) {
    v.required("k_ascending", m.k_ascending);
    v.required("k_descending", m.k_descending);
    if (m.basis == model::Basis::spline) v.numbers("input_map", m.input_map);
  }
  if (m.kind == model::Hysteresis::kind() || m.kind == average_kind) v.numbers("output_map", m.output_map);
  v.choice("symmetry", m.symmetry);
}

template <class V>
void visit(V& v, IdentifiedFrom& from) {
  v.required("samples", from.samples, {.lo = 1.0});
  v.required("delay_s", from.delay_s, not_negative, {.meaning = "of the output behind the input"});
  v.required("rms_percent", from.rms_percent, not_negative,
             {.meaning = "of the dataset's output span", .digits = 4});
  v.required("max_percent", from.max_percent, not_negative, {.digits = 4});
}

template <class V>
void visit(V& v, model::Dynamics& d) {
  v.required("resonance_Hz", d.mode.natural_frequency_Hz, positive);
  v.required("damping_ratio", d.mode.damping_ratio, not_negative);
  v.required("delay_s", d.delay_s, not_negative);
}

template <class V>
void visit(V& v, model::OutputCreep::Config& c) {
  v.required("per_decade", c.per_decade, {.lo = -0.1, .hi = 0.1}, {.meaning = "share of the output"});
  v.required("from_s", c.from_s, positive);
  v.required("to_s", c.to_s, positive);
}

/// The tables of a model file.
template <class V>
void visit_tables(V& v, ModelFile& m) {
  const auto plain = [](V& sub, auto& value) { visit(sub, value); };
  v.table("hysteresis", m, plain);
  v.optional_table("creep", m.creep, plain);
  v.optional_table("dynamics", m.dynamics, plain);
  v.optional_table("identification", m.identified_from, plain);
}

/// [[learning]] of a file that the controller has saved: one segment.
struct LearntFile {
  std::vector<double> correction_um;
};
template <class V>
void visit(V& v, LearntFile& l) {
  v.numbers("correction_um", l.correction_um);
}

/// [stop] of a file that the controller has saved.
struct StopFile {
  std::string reason;
};
template <class V>
void visit(V& v, StopFile& s) {
  v.required("reason", s.reason);
}

/// [memory] of a memory file.
struct MemoryFile {
  std::string kind;
  std::string model;
  model::Origin origin = model::Origin::virgin;
  std::vector<double> turning_inputs;
  std::vector<double> turning_outputs;
  double input = 0.0;
  double output = 0.0;
  std::uint64_t merged = 0;
  std::vector<double> plays;
  std::vector<double> creep;
  double time_s = 0.0;
};

template <class V>
void visit(V& v, MemoryFile& m) {
  v.choice("kind", m.kind, memory_kinds);
  v.optional("model", m.model);
  v.required("input", m.input);
  v.optional("output", m.output);
  v.numbers("creep", m.creep);
  v.optional("time_s", m.time_s);
  if (m.kind == model::PrandtlIshlinskii::kind()) {
    v.required("plays", m.plays);
    return;
  }
  v.choice("origin", m.origin);
  v.numbers("turning_inputs", m.turning_inputs);
  v.numbers("turning_outputs", m.turning_outputs);
  v.optional("merged", m.merged);
}

}  // namespace hystcan::config
