#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace hystcan::identification {

/// A quantity that the search determines beside the curves. `dataset` is 0 except for the gain of a dataset.
struct Quantity {
  enum class Kind : std::uint8_t {
    k_ascending,
    k_descending,
    common_k,
    initial_memory,
    lower_threshold,
    upper_threshold,
    gain,               ///< of a dataset, against the first one
    gain_of_old_model,  ///< the old model's gain against the first dataset
    delay,
    creep,
    input_map,
    output_map,
    mode,  ///< with its delay
  };
  Kind kind = Kind::delay;
  std::size_t dataset = 0;
  bool operator==(const Quantity&) const = default;
};

/// Its name in a report, with the number of the dataset from 1 on.
std::string to_string(const Quantity& quantity);

}  // namespace hystcan::identification
