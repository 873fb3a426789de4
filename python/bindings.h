// The parts of the module `hystcan._hystcan`.
#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>

namespace hystcan::python {

class Model;

void bind_errors(pybind11::module_& module);
void bind_model(pybind11::module_& module);
void bind_identification(pybind11::module_& module);
void bind_run(pybind11::module_& module);
void bind_rehearsal(pybind11::module_& module);

/// As json.loads() gives it.
pybind11::object python_of(const nlohmann::json& value);
/// Makes `T.__new__` raise TypeError: objects of the class come from `instead`. Without this, pybind11 takes the
/// memory of an object that nothing has constructed for one.
template <class T>
void forbid_new(pybind11::class_<T>& type, const char* instead) {
  type.attr("__new__") = pybind11::cpp_function(
      [instead](const pybind11::args&, const pybind11::kwargs&) { throw pybind11::type_error(instead); });
}

}  // namespace hystcan::python
