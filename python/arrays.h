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

namespace pybind11::detail {

/// As pybind11's own, but a lack of memory stays one: its own makes it a wrong type.
template <>
struct pyobject_caster<hystcan::python::Array> {
  using type = hystcan::python::Array;

  bool load(handle source, bool convert) {
    if (!convert && !type::check_(source)) return false;
    try {
      value = type(reinterpret_borrow<object>(source));
    } catch (error_already_set& failed) {
      if (failed.matches(PyExc_MemoryError)) throw;
      return false;
    }
    return true;
  }
  static handle cast(const handle& source, return_value_policy, handle) { return source.inc_ref(); }
  PYBIND11_TYPE_CASTER(type, handle_type_name<type>::name);
};

}  // namespace pybind11::detail
