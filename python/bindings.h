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
/// Runs the handlers of Python's signals. Throws what they raise: KeyboardInterrupt at Ctrl-C.
void check_signals();

}  // namespace hystcan::python
