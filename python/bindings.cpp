#include "python/bindings.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <thread>

#include "base/error.h"

namespace hystcan::python {

std::span<const double> gapped_column(const Array& array, const char* name) {
  if (array.ndim() != 1)
    throw py::value_error(fmt::format("{} has {} dimensions, expected 1", name, array.ndim()));
  return {array.data(), static_cast<std::size_t>(array.size())};
}

std::span<const double> column(const Array& array, const char* name) {
  const std::span<const double> values = gapped_column(array, name);
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

namespace {

std::atomic<bool> interpreter_ends{false};
std::thread::id ending_thread;  // written before interpreter_ends
std::atomic<int> unlocked_threads{0};

void stay_if_the_interpreter_ends() {
  if (!interpreter_ends || std::this_thread::get_id() == ending_thread) return;
  --unlocked_threads;
  while (true) pause();
}

/// Waits until no other thread needs Python's lock. Python calls this in the main thread, with the lock,
/// before the interpreter ends.
void wait_for_threads() {
  constexpr auto longest = std::chrono::seconds(30);  // maximum time between two calls of check_signals()
  const auto deadline = std::chrono::steady_clock::now() + longest;
  ending_thread = std::this_thread::get_id();
  interpreter_ends = true;
  const py::gil_scoped_release released;
  while (unlocked_threads > 0 && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

Unlocked::Unlocked() {
  ++unlocked_threads;
  thread_ = PyEval_SaveThread();
}

// The thread counts until it has the lock again; wait_for_threads() waits for that.
Unlocked::~Unlocked() {
  stay_if_the_interpreter_ends();
  PyEval_RestoreThread(thread_);
  --unlocked_threads;
}

void check_signals() {
  stay_if_the_interpreter_ends();
  const py::gil_scoped_acquire python;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void bind_end_of_interpreter() {
  py::module_::import("atexit").attr("register")(py::cpp_function(&wait_for_threads));
}

void bind_errors(py::module_& module) {
  static const py::exception<Error> error(module, "Error", PyExc_ValueError);
  module.attr("Error").attr("__doc__") =
      "Raised if a file, a value or a dataset is not valid. The text is the message of the command line.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& refused) {
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
