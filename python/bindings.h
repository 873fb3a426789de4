// What the parts of the module `hystcan._hystcan` share: numpy arrays, Python's lock, JSON.
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

/// What Python gives, as float64 in one piece.
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Throws ValueError unless the array has one dimension and finite values.
std::span<const double> column(const Array& array, const char* name);
/// Values may be missing: NaN.
std::span<const double> gapped_column(const Array& array, const char* name);
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

/// Releases Python's lock for a scope, in which no Python object is touched. A thread whose interpreter ends
/// meanwhile does not come back from the scope: Python would end it by an exception that C++ cannot pass on.
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* thread_;
};

/// Within such a scope: runs the handlers of Python's signals. Throws what they raise: KeyboardInterrupt at
/// Ctrl-C.
void check_signals();

/// At the interpreter's end, waits until no other thread needs its lock.
void bind_end_of_interpreter();

void bind_errors(pybind11::module_& module);
void bind_model(pybind11::module_& module);
void bind_identification(pybind11::module_& module);
void bind_run(pybind11::module_& module);
void bind_rehearsal(pybind11::module_& module);

/// As json.loads() gives it.
pybind11::object python_of(const nlohmann::json& value);
/// Makes `T.__new__` raise TypeError: objects of the class come from `instead`. Without this, pybind11 takes
/// the memory of an object that nothing has constructed for one.
template <class T>
void forbid_new(pybind11::class_<T>& type, const char* instead) {
  type.attr("__new__") = pybind11::cpp_function(
      [instead](const pybind11::args&, const pybind11::kwargs&) { throw pybind11::type_error(instead); });
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
