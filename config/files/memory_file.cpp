#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/files/model_file.h"
#include "config/files/model_schema.h"

namespace hystcan::config {
namespace {

/// The contents of a memory file. A file that a controller saved also has what it learnt, and [stop].
struct Contents {
  MemoryFile memory;
  std::vector<LearntFile> learnt{};
  std::optional<StopFile> stop{};
};

Contents read(const Document& document) {
  Contents raw;
  const auto plain = [](Reader& sub, auto& value) { visit(sub, value); };
  Reader reader(document, document.root(), "");
  reader.table("memory", raw.memory, plain);
  reader.optional_table("stop", raw.stop, plain);
  // Former controllers wrote a learnt gain and offset of the model, which no longer exist.
  std::optional<double> former{};
  reader.optional_table("correction", former, [](Reader& sub, double& ignored) {
    sub.optional("gain", ignored);
    sub.optional("offset_um", ignored);
  });
  reader.optional_list("learning", raw.learnt, plain);
  reader.finish();
  return raw;
}

template <class Model>
Contents read(const Document& document, const Model& model) {
  Contents raw = read(document);
  const MemoryFile& memory = raw.memory;
  if (memory.kind != model.kind())
    document.fail_at("memory.kind", fmt::format("kind is \"{}\", expected \"{}\" as of the model",
                                                memory.kind, model.kind()));
  const std::string fingerprint = fmt::format("{:016x}", model.fingerprint());
  if (!memory.model.empty() && memory.model != fingerprint)
    document.fail_at("memory.model",
                     fmt::format("model is \"{}\", expected \"{}\": the memory of another model",
                                 memory.model, fingerprint));
  return raw;
}

model::TurningPoints turning_points(const Document& document, const MemoryFile& raw) {
  const bool has_output = static_cast<bool>(document.root().at_path("memory.output"));
  return {.origin = raw.origin,
          .inputs = raw.turning_inputs,
          .outputs = raw.turning_outputs,
          .input = raw.input,
          .output = has_output ? std::optional(raw.output) : std::nullopt,
          .merged = raw.merged};
}

template <class Law>
model::HysteresisState remembered(const Document& document, const MemoryFile& raw,
                                  const model::MemoryModel<Law>& model, std::size_t capacity) {
  try {
    return model.remembering(turning_points(document, raw), capacity);
  } catch (const model::MemoryError& error) {
    const bool present = error.index >= raw.turning_inputs.size();
    document.fail_at(present ? "memory.input" : fmt::format("memory.turning_inputs[{}]", error.index),
                     error.what());
  }
}

}  // namespace

template <class Law>
model::HysteresisState load_memory(const std::filesystem::path& file, const model::MemoryModel<Law>& model,
                                   std::size_t capacity) {
  const Document document(file, {}, largest_model_file);
  return remembered(document, read(document, model).memory, model, capacity);
}

template model::HysteresisState load_memory(const std::filesystem::path&,
                                            const model::MemoryModel<model::ExponentialConvergence>&,
                                            std::size_t);
template model::HysteresisState load_memory(const std::filesystem::path&,
                                            const model::MemoryModel<model::AffineMap>&, std::size_t);
template model::HysteresisState load_memory(const std::filesystem::path&,
                                            const model::MemoryModel<model::EverettLaw>&, std::size_t);

SavedState load_state(const std::filesystem::path& file, const model::Hysteresis& model) {
  const Document document(file, {}, largest_model_file);
  // [stop] comes last and shows that the file is complete: a number that is cut off is still a valid number.
  if (!document.root().contains("stop"))
    document.fail_at("", "missing table [stop], expected a whole file that a controller has saved");
  if (document.root().at_path("memory.creep"))
    document.fail_at("memory.creep", "creep stands in a state file, expected it in a memory file only");
  Contents raw = read(document, model);
  std::vector<std::vector<double>> learnt;
  for (LearntFile& segment : raw.learnt) learnt.push_back(std::move(segment.correction_um));
  return {.memory = remembered(document, raw.memory, model, model::Hysteresis::default_capacity),
          .learnt = std::move(learnt)};
}

model::PlayState load_memory(const std::filesystem::path& file, const model::PrandtlIshlinskii& model,
                             std::size_t) {
  const Document document(file, {}, largest_model_file);
  const MemoryFile raw = read(document, model).memory;
  try {
    return model.restore(raw.input, raw.plays);
  } catch (const std::invalid_argument& error) {
    document.fail_at("memory.plays", error.what());
  }
}

std::optional<model::HeldCreep::State> load_creep_memory(const std::filesystem::path& file,
                                                         const model::OutputCreep& creep, double h) {
  const Document document(file, {}, largest_model_file);
  const MemoryFile raw = read(document).memory;
  const bool has_time = static_cast<bool>(document.root().at_path("memory.time_s"));
  if (!document.root().at_path("memory.creep")) {
    if (has_time) document.fail_at("memory.time_s", "time_s stands without creep, expected both");
    return std::nullopt;
  }
  if (creep.lags() == 0)
    document.fail_at("memory.creep", "creep stands in the memory of a model without [creep], expected none");
  if (raw.creep.size() != creep.lags())
    document.fail_at("memory.creep",
                     fmt::format("creep has {} values, expected {}: the lags of the model's [creep]",
                                 raw.creep.size(), creep.lags()));
  return model::HeldCreep::State{
      .creep = {raw.creep}, .h = h, .time_s = has_time ? std::optional(raw.time_s) : std::nullopt};
}

std::string creep_memory_text(const model::HeldCreep::State& state) {
  std::string text = fmt::format("creep = [{}]\n", fmt::join(state.creep.late, ", "));
  if (state.time_s) text += fmt::format("time_s = {}\n", *state.time_s);
  return text;
}

}  // namespace hystcan::config
