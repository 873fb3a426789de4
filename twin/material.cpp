#include "twin/material.h"

#include <utility>

namespace hystcan::twin {
namespace {

template <class Model>
bool is_even(const Model& model) {
  if constexpr (requires { model.symmetry(); })
    return model.symmetry() == model::Symmetry::even;
  else
    return false;
}

}  // namespace

template <class Model>
Material::Kind<Model> Material::virgin(Model model, double drive, std::size_t branches) {
  if constexpr (requires { model.virgin(drive, branches); }) {
    auto state = model.virgin(drive, branches);
    return {std::move(model), std::move(state)};
  } else {
    auto state = model.virgin(drive);
    return {std::move(model), std::move(state)};
  }
}

Material::Material(const model::AnyParameters& parameters, double drive, std::size_t branches)
    : kind_(std::visit([&](const auto& model) { return decltype(kind_)(virgin(model, drive, branches)); },
                       model::model_of(parameters))),
      even_(std::visit([](const auto& kind) { return is_even(kind.model); }, kind_)),
      drive_(drive) {}

double Material::go_to(double drive) {
  if (even_) pass_zero(drive);
  drive_ = drive;
  return std::visit([drive](auto& kind) { return kind.model.advance(kind.state, drive).value; }, kind_);
}

double Material::look_at(double drive) {
  if (even_) pass_zero(drive);
  return std::visit([drive](auto& kind) { return kind.model.forward(kind.state, drive).value; }, kind_);
}

void Material::pass_zero(double drive) {
  if (drive * drive_ < 0.0) go_to(0.0);
}

}  // namespace hystcan::twin
