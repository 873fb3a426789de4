#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/words.h"

namespace hystcan::identification {

/// A quantity that the search adds to the unknowns, besides the curves. `dataset` is the index of the dataset
/// to which a gain or an initial memory belongs; otherwise it is 0.
struct Quantity {
  enum class Kind : std::uint8_t {
    k_ascending,
    k_descending,
    common_k,
    initial_memory,
    lower_threshold,
    upper_threshold,
    gain,               ///< gain of a dataset relative to the first one
    gain_of_old_model,  ///< gain of the old model relative to the first dataset
    delay,
    creep,
    input_map,
    output_map,
    mode,  ///< a second-order mode and its delay
  };
  Kind kind = Kind::delay;
  std::size_t dataset = 0;
  bool operator==(const Quantity&) const = default;
};
constexpr auto words(Quantity::Kind) {
  return std::to_array<std::string_view>({"k_ascending", "k_descending", "k", "initial memory",
                                          "lower threshold", "upper threshold", "gain of dataset",
                                          "gain of the old model", "delay", "creep", "an input map",
                                          "output map", "a mode with a delay"});
}

/// Returns the name of the quantity for a report. The name of a gain contains the number of its dataset,
/// counted from 1.
inline std::string to_string(const Quantity& quantity) {
  std::string name(word_of(quantity.kind));
  return quantity.kind == Quantity::Kind::gain ? name + " " + std::to_string(quantity.dataset + 1) : name;
}

}  // namespace hystcan::identification
