// The keys of model and memory files: one `visit` for each struct, both to read and to print it.
#pragma once

#include "config/document/document.h"
#include "config/files/model_file.h"

namespace hystcan::config {

/// [hysteresis] of a model file. The keys depend on the kind.
struct ModelFile {
  IdentifiedFrom identified_from;
  std::string kind;
  std::string input_unit;
  std::string output_unit;
  double input_min = 0.0;
  double input_max = 0.0;
  std::string basis;
  std::vector<double> ascending;
  std::vector<double> descending;
  double k_ascending = 0.0;
  double k_descending = 0.0;
  std::string symmetry = "none";
  double offset = 0.0;
  double gain = 0.0;
  std::vector<double> thresholds;
  std::vector<double> weights;
};

template <class V>
void visit(V& v, ModelFile& m) {
  v.choice("kind", m.kind,
           {"recursive-memory", "average", "linear-mapping", "prandtl-ishlinskii", "preisach"});
  v.required("input_unit", m.input_unit);
  v.required("output_unit", m.output_unit);
  v.required("input_min", m.input_min);
  v.required("input_max", m.input_max);
  if (m.kind == "prandtl-ishlinskii" || m.kind == "preisach") {
    v.required("offset", m.offset);
    v.required("gain", m.gain);
    if (m.kind == "prandtl-ishlinskii") v.required("thresholds", m.thresholds);
    v.required("weights", m.weights);
    return;
  }
  v.choice("basis", m.basis, {"power", "chebyshev"});
  v.required("ascending", m.ascending);
  v.required("descending", m.descending);
  if (m.kind == "recursive-memory") {
    v.required("k_ascending", m.k_ascending);
    v.required("k_descending", m.k_descending);
  }
  v.choice("symmetry", m.symmetry, {"none", "even"});
}

template <class V>
void visit(V& v, IdentifiedFrom& from) {
  v.required("samples", from.samples, {.lo = 1.0});
  v.required("delay_s", from.delay_s, not_negative);
  v.required("rms_percent", from.rms_percent, not_negative);
  v.required("max_percent", from.max_percent, not_negative);
}

/// [stop] of a file that the controller has saved.
struct StopFile {
  std::string reason;
};
template <class V>
void visit(V& v, StopFile& s) {
  v.required("reason", s.reason);
}
template <class V>
void visit(V& v, controller::ModelCorrection& c) {
  v.required("gain", c.gain, positive);
  v.required("offset_um", c.offset_um);
}

/// [memory] of a memory file.
struct MemoryFile {
  std::string kind;
  std::string model;
  std::string origin;
  std::vector<double> turning_inputs;
  std::vector<double> turning_outputs;
  double input = 0.0;
  double output = 0.0;
  std::uint64_t merged = 0;
  std::vector<double> plays;
};

template <class V>
void visit(V& v, MemoryFile& m) {
  v.choice("kind", m.kind, {"recursive-memory", "linear-mapping", "prandtl-ishlinskii", "preisach"});
  v.optional("model", m.model);
  v.required("input", m.input);
  v.optional("output", m.output);
  if (m.kind == "prandtl-ishlinskii") {
    v.required("plays", m.plays);
    return;
  }
  v.choice("origin", m.origin, {"virgin", "lower-threshold", "upper-threshold"});
  v.numbers("turning_inputs", m.turning_inputs);
  v.numbers("turning_outputs", m.turning_outputs);
  v.optional("merged", m.merged);
}

}  // namespace hystcan::config
