// numpy arrays and columns of numbers.
#pragma once

#include <pybind11/numpy.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace hystcan::python {

namespace py = pybind11;

/// What Python gives, as float64 in one piece.
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Throws ValueError unless the array has one dimension and finite values.
std::span<const double> column(const Array& array, const char* name);
std::vector<double> vector_of(const Array& array, const char* name);

/// Without a copy: the array owns the vector.
inline py::array_t<double> array_of(std::vector<double> values) {
  auto owned = std::make_unique<std::vector<double>>(std::move(values));
  const auto size = static_cast<py::ssize_t>(owned->size());
  const double* const data = owned->data();
  const py::capsule owner(owned.release(),
                          [](void* held) { delete static_cast<std::vector<double>*>(held); });
  return {{size}, {static_cast<py::ssize_t>(sizeof(double))}, data, owner};
}

}  // namespace hystcan::python
