#include <cerrno>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "base/error.h"
#include "can/dbc/database.h"
#include "python/bindings.h"
#include "python/unlocked.h"
#include "storage/hdf5.h"

namespace hystcan::python {

namespace py = pybind11;

void bind_errors(py::module_& module) {
  static const py::exception<Error> error(module, "Error", PyExc_ValueError);
  module.attr("Error").attr("__doc__") =
      "A file, a value or a dataset that hystcan refuses; the text is that of the command line.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& refused) {
      PyErr_SetString(error.ptr(), refused.what());
    } catch (const can::DbcError& refused) {
      PyErr_SetString(error.ptr(), refused.what());
    } catch (const storage::Hdf5Error& refused) {
      PyErr_SetString(error.ptr(), refused.what());
    } catch (const std::invalid_argument& refused) {
      PyErr_SetString(error.ptr(), refused.what());
    } catch (const RunError& failed) {
      PyErr_SetString(PyExc_OSError, failed.what());
    } catch (const std::system_error& failed) {
      const py::object arguments = py::make_tuple(failed.code().value(), failed.what());
      PyErr_SetObject(PyExc_OSError, arguments.ptr());
    }
  });
}

py::object python_of(const nlohmann::json& value) {
  return py::module_::import("json").attr("loads")(value.dump());
}

}  // namespace hystcan::python

PYBIND11_MODULE(_hystcan, module) {
  namespace python = hystcan::python;
  module.attr("__version__") = HYSTCAN_VERSION;
  python::bind_errors(module);
  python::bind_end_of_interpreter();
  python::bind_model(module);
  python::bind_identification(module);
  python::bind_run(module);
  python::bind_rehearsal(module);
}
