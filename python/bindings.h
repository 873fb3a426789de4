// Shared by the parts of the module `hystcan._hystcan`: numpy arrays, Python's lock, JSON.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace hystcan::python {

namespace py = pybind11;

/// An argument from Python, converted to contiguous float64.
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Throws ValueError unless the array has one dimension and finite values.
std::span<const double> column(const Array& array, const char* name);
/// Like column(), but values may be missing (NaN).
std::span<const double> gapped_column(const Array& array, const char* name);
std::vector<double> vector_of(const Array& array, const char* name);

/// Returns an array that owns the vector, without a copy.
inline py::array_t<double> array_of(std::vector<double> values) {
  auto owned = std::make_unique<std::vector<double>>(std::move(values));
  const auto size = static_cast<py::ssize_t>(owned->size());
  const double* const data = owned->data();
  const py::capsule owner(owned.release(),
                          [](void* held) { delete static_cast<std::vector<double>*>(held); });
  return {{size}, {static_cast<py::ssize_t>(sizeof(double))}, data, owner};
}

/// Releases Python's lock for a scope that must not touch Python objects. If the interpreter ends during the
/// scope, the thread never leaves the scope: Python would end it by an exception that C++ can't pass on.
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* thread_;
};

/// Call this within Unlocked: runs Python's signal handlers. Throws the exceptions that they raise, such as
/// KeyboardInterrupt at Ctrl-C.
void check_signals();

/// Makes the interpreter, when it ends, wait until no other thread needs its lock.
void bind_end_of_interpreter();

void bind_errors(pybind11::module_& module);
void bind_model(pybind11::module_& module);
void bind_identification(pybind11::module_& module);
void bind_run(pybind11::module_& module);
void bind_rehearsal(pybind11::module_& module);

/// Converts JSON to Python objects, like json.loads().
pybind11::object python_of(const nlohmann::json& value);
/// Makes `T.__new__` raise TypeError: objects of the class are made by `instead`. Otherwise pybind11 would
/// use the memory of an object that was never constructed.
template <class T>
void forbid_new(pybind11::class_<T>& type, const char* instead) {
  type.attr("__new__") = pybind11::cpp_function(
      [instead](const pybind11::args&, const pybind11::kwargs&) { throw pybind11::type_error(instead); });
}

}  // namespace hystcan::python

namespace pybind11::detail {

/// Like pybind11's caster, but passes on MemoryError, which pybind11 turns into a type error.
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
