#include "identification/quantity.h"

#include <array>
#include <string_view>

namespace hystcan::identification {
namespace {

constexpr std::array<std::string_view, static_cast<std::size_t>(Quantity::Kind::mode) + 1> quantity_names{
    "k_ascending",
    "k_descending",
    "k",
    "initial memory",
    "lower threshold",
    "upper threshold",
    "gain of dataset",
    "gain of the old model",
    "delay",
    "creep",
    "an input map",
    "output map",
    "a mode with a delay"};

}  // namespace

std::string to_string(const Quantity& quantity) {
  std::string name(quantity_names[static_cast<std::size_t>(quantity.kind)]);
  return quantity.kind == Quantity::Kind::gain ? name + " " + std::to_string(quantity.dataset + 1) : name;
}

}  // namespace hystcan::identification
