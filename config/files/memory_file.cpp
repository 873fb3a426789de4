#include "config/files/memory_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstdint>
#include <utility>

#include "config/document/document.h"

namespace hystcan::config {
namespace {

constexpr std::array<std::string_view, 4> memory_kinds{
    model::Hysteresis::kind(), model::LinearMapping::kind(), model::PrandtlIshlinskii::kind(),
    model::Preisach::kind()};

/// The content of a memory file. The first members are the keys of [memory].
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
  // The members below are from other tables, which only a file saved by a controller has.
  std::vector<std::vector<double>> learnt{};  ///< list correction_um of each table [[learning]]
  std::optional<std::string> stop{};          ///< value of the key `reason` in the table [stop]
};

template <class V>
void visit(V& v, MemoryFile& m) {
  v.choice("kind", m.kind, memory_kinds);
  v.optional("model", m.model);
  v.required("input", m.input);
  v.optional("output", m.output);
  v.optional("creep", m.creep);
  v.optional("time_s", m.time_s);
  if (m.kind == model::PrandtlIshlinskii::kind()) {
    v.required("plays", m.plays);
    return;
  }
  v.required("origin", m.origin);
  v.optional("turning_inputs", m.turning_inputs);
  v.optional("turning_outputs", m.turning_outputs);
  v.optional("merged", m.merged);
}

MemoryFile read(const Document& document) {
  MemoryFile raw;
  const auto plain = [](Reader& sub, auto& value) { visit(sub, value); };
  Reader reader(document, document.root(), "");
  reader.table("memory", raw, plain);
  reader.optional_table("stop", raw.stop,
                        [](Reader& sub, std::string& reason) { sub.required("reason", reason); });
  // Ignores [correction]: earlier versions of the controller learnt a gain and an offset and saved them here.
  std::optional<double> former{};
  reader.optional_table("correction", former, [](Reader& sub, double& ignored) {
    sub.optional("gain", ignored);
    sub.optional("offset_um", ignored);
  });
  reader.optional_list("learning", raw.learnt, [](Reader& sub, std::vector<double>& correction_um) {
    sub.optional("correction_um", correction_um);
  });
  reader.finish();
  return raw;
}

template <class Model>
MemoryFile read(const Document& document, const Model& model) {
  MemoryFile memory = read(document);
  if (memory.kind != model.kind())
    document.fail_at("memory.kind", fmt::format("kind is \"{}\", expected \"{}\", the kind of the model",
                                                memory.kind, model.kind()));
  const std::string fingerprint = fmt::format("{:016x}", model.fingerprint());
  if (!memory.model.empty() && memory.model != fingerprint)
    document.fail_at("memory.model",
                     fmt::format("model is \"{}\", expected \"{}\": the memory belongs to another model",
                                 memory.model, fingerprint));
  return memory;
}

template <class Model>
model::HysteresisState remembered(const Document& document, const MemoryFile& raw, const Model& model,
                                  std::size_t capacity) {
  const bool has_output = document.has("memory.output");
  try {
    return model.remembering({.origin = raw.origin,
                              .inputs = raw.turning_inputs,
                              .levels = raw.turning_outputs,
                              .input = raw.input,
                              .level = has_output ? std::optional(raw.output) : std::nullopt,
                              .merged = raw.merged},
                             capacity);
  } catch (const model::MemoryError& error) {
    const bool present = error.index >= raw.turning_inputs.size();
    const auto turning_point = fmt::format("memory.turning_inputs[{}]", error.index);
    throw Error(document.place_at(present ? "memory.input" : turning_point), error);
  }
}

}  // namespace

template <class Model>
model::HysteresisState load_memory(const std::filesystem::path& file, const Model& model,
                                   std::size_t capacity) {
  const Document document(file, largest_model_file);
  return remembered(document, read(document, model), model, capacity);
}

template model::HysteresisState load_memory(const std::filesystem::path&, const model::Hysteresis&,
                                            std::size_t);
template model::HysteresisState load_memory(const std::filesystem::path&, const model::LinearMapping&,
                                            std::size_t);
template model::HysteresisState load_memory(const std::filesystem::path&, const model::Preisach&,
                                            std::size_t);

SavedState load_state(const std::filesystem::path& file, const model::Hysteresis& model) {
  const Document document(file, largest_model_file);
  // The table [stop] is the last one, so its presence shows that the file is complete. Without [stop], a file
  // that was cut within a number would be read without an error.
  if (!document.root().contains("stop"))
    document.fail_at("", "missing table [stop], expected a complete state file of a controller");
  if (document.has("memory.creep"))
    document.fail_at("memory.creep", "creep is not allowed in a state file, only in a memory file");
  MemoryFile raw = read(document, model);
  return {.memory = remembered(document, raw, model, model::Hysteresis::default_capacity),
          .learnt = std::move(raw.learnt)};
}

model::PlayState load_memory(const std::filesystem::path& file, const model::PrandtlIshlinskii& model,
                             std::size_t) {
  const Document document(file, largest_model_file);
  const MemoryFile raw = read(document, model);
  return at_place(document.place_at("memory.plays"), [&] { return model.restore(raw.input, raw.plays); });
}

std::optional<model::HeldCreep::State> load_creep_memory(const std::filesystem::path& file,
                                                         const model::OutputCreep& creep, double h) {
  const Document document(file, largest_model_file);
  const MemoryFile raw = read(document);
  const bool has_time = document.has("memory.time_s");
  if (!document.has("memory.creep")) {
    if (has_time) document.fail_at("memory.time_s", "time_s is present without creep, expected both keys");
    return std::nullopt;
  }
  if (creep.lags() == 0)
    document.fail_at("memory.creep", "creep is not allowed in the memory of a model without [creep]");
  if (raw.creep.size() != creep.lags())
    document.fail_at("memory.creep",
                     fmt::format("creep has {} values, expected {}, one for each lag in the model's [creep]",
                                 raw.creep.size(), creep.lags()));
  return model::HeldCreep::State{
      .creep = raw.creep, .h = h, .time_s = has_time ? std::optional(raw.time_s) : std::nullopt};
}

std::string creep_memory_text(const model::HeldCreep::State& state) {
  std::string text = fmt::format("creep = [{}]\n", fmt::join(state.creep, ", "));
  if (state.time_s) text += fmt::format("time_s = {}\n", *state.time_s);
  return text;
}

}  // namespace hystcan::config
