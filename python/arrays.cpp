#include "python/arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hystcan::python {

std::span<const double> column(const Array& array, const char* name) {
  if (array.ndim() != 1)
    throw py::value_error(fmt::format("{} has {} dimensions, expected 1", name, array.ndim()));
  const std::span<const double> values(array.data(), static_cast<std::size_t>(array.size()));
  const auto bad = std::ranges::find_if_not(values, [](double value) { return std::isfinite(value); });
  if (bad != values.end())
    throw py::value_error(
        fmt::format("{}[{}] is {}, expected a finite number", name, bad - values.begin(), *bad));
  return values;
}

std::vector<double> vector_of(const Array& array, const char* name) {
  const std::span<const double> values = column(array, name);
  return {values.begin(), values.end()};
}

}  // namespace hystcan::python
