// For any bytes, load_memory and load_creep_memory either refuse them with their place, or return a state
// from which the model continues.
#include <cmath>

#include "config/files/memory_file.h"
#include "config/files/model_file.h"
#include "tests/fuzz/refusal.h"

using namespace hystcan;

namespace {

model::Hysteresis piezo() {
  const model::Interval range{0.0, 100.0};
  return model::Hysteresis({"V", "um",
                            model::ReferenceCurve(model::Basis::power, {0.0, 0.25, 4e-4, 1e-6}, range),
                            model::ReferenceCurve(model::Basis::power, {0.8, 0.372, -8e-4}, range), 0.05,
                            0.04, model::Symmetry::none});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const model::Hysteresis model = piezo();
  static const model::PrandtlIshlinskii plays({"V", "um", {0.0, 100.0}, 0.0, 0.2, {5.0, 20.0}, {0.05, 0.05}});
  const fuzz::File file(data, size);
  fuzz::read_or_refuse(file, [&] {
    model::HysteresisState state = config::load_memory(file.path(), model, 16);
    fuzz::demand(std::isfinite(state.output) && state.depth() <= 16);
    fuzz::demand(std::isfinite(model.advance(state, 50.0).value));
  });
  fuzz::read_or_refuse(file, [&] {
    model::PlayState state = config::load_memory(file.path(), plays, 16);
    fuzz::demand(std::isfinite(plays.advance(state, 50.0).value));
  });
  fuzz::read_or_refuse(file, [&] {
    const model::OutputCreep creep({.per_decade = 0.02});
    const auto state = config::load_creep_memory(file.path(), creep, 10.0);
    fuzz::demand(!state || state->creep.size() == creep.lags());
  });
  return 0;
}
