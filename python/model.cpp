#include "python/model.h"

namespace hystcan::python {
namespace {

template <class Law>
bool has_even_symmetry(const model::MemoryModel<Law>& model) {
  return model.symmetry() == model::Symmetry::even;
}
bool has_even_symmetry(const model::PrandtlIshlinskii&) { return false; }

}  // namespace

Model Model::load(const std::filesystem::path& file, bool beyond_limit) {
  Model model;
  model.model = std::make_shared<const model::AnyModel>(
      beyond_limit ? model::AnyModel(config::load_model_beyond_limit(file)) : config::load_any_model(file));
  model.name = file.filename().string();
  std::visit(
      [&](const auto& each) {
        model.input_unit = each.parameters().input_unit;
        model.output_unit = each.parameters().output_unit;
      },
      *model.model);
  model.lag = config::load_lag(file);
  return model;
}

Model Model::quasi_static() const {
  Model alone = *this;
  alone.model = std::make_shared<const model::AnyModel>(*model);  // its memories are others
  alone.lag = {.delay_s = lag.delay_s};
  return alone;
}

std::string Model::kind() const {
  return std::visit([](const auto& each) { return std::string(each.kind()); }, *model);
}

model::Interval Model::input_range() const {
  return std::visit([](const auto& each) { return each.input_range(); }, *model);
}

bool Model::is_even() const {
  return std::visit([](const auto& each) { return has_even_symmetry(each); }, *model);
}

}  // namespace hystcan::python
