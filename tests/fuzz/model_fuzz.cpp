// For any bytes, load_any_model either refuses them with their place, or returns a model that moves from
// threshold to threshold and back by its inverse.
#include <cmath>
#include <variant>

#include "config/files/model_file.h"
#include "tests/fuzz/refusal.h"

using namespace hystcan;

namespace {

template <class Model>
void use(const Model& model) {
  const model::Interval range = model.input_range();
  auto state = model.virgin(range.lo);
  for (const double share : {0.7, 0.2, 0.5, 1.0, 0.4}) {
    const double v = range.lo + share * range.span();
    const double x = model.advance(state, v).value;
    fuzz::demand(std::isfinite(x));
    fuzz::demand(model.inverse(state, x).value == state.input);
    fuzz::demand(range.contains(model.inverse(state, model.reachable(state).lo).value));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::File file(data, size);
  fuzz::read_or_refuse(
      file, [&] { std::visit([](const auto& model) { use(model); }, config::load_any_model(file.path())); });
  return 0;
}
