#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "python/bindings.h"
#include "runs/export.h"
#include "runs/run.h"

namespace hystcan::python {
namespace {

using runs::Run;

std::size_t index_of(const Run& run, const std::optional<std::string>& axis) {
  if (axis || run.info().axes.size() != 1) return run.axis_index(axis.value_or(""));
  return 0;
}

std::vector<std::string> axes_of_run(const Run& run) {
  std::vector<std::string> names;
  for (const runs::RunAxis& axis : run.info().axes) names.push_back(axis.name);
  return names;
}

py::dict read(const Run& run, const std::optional<std::vector<std::string>>& signals,
              const std::optional<std::string>& axis, const std::optional<double>& from_s,
              const std::optional<double>& to_s) {
  const std::size_t index = index_of(run, axis);
  const std::vector<std::string> names = signals_of(
      run, index, {.axis = {}, .signals = signals.value_or(std::vector<std::string>{}), .span = {}});
  constexpr double infinity = std::numeric_limits<double>::infinity();
  runs::Columns columns;
  {
    const Unlocked unlocked;
    columns = run.read(index, names, {.from_s = from_s.value_or(-infinity), .to_s = to_s.value_or(infinity)});
  }
  py::dict result;
  for (std::size_t i = 0; i < names.size(); ++i) result[names[i].c_str()] = array_of(std::move(columns[i]));
  return result;
}

template <class Value>
py::dict of_each_signal(const Run& run, const std::optional<std::string>& axis, Value value) {
  py::dict result;
  for (const runs::Signal& signal : run.signals(index_of(run, axis)))
    result[signal.name.c_str()] = value(signal);
  return result;
}

}  // namespace

void bind_run(py::module_& module) {
  py::class_<Run> type(module, "Run",
                       R"(A recorded run: a folder that a controller has recorded, or a CSV of cycles.

A run that was killed, or that is still being recorded, is read up to its last whole row.
)");
  forbid_new(type, "a Run comes from Run.open()");
  type.def_static(
          "open", [](const std::filesystem::path& path) { return Run(path); }, py::arg("path"),
          py::call_guard<Unlocked>(), "Raises Error if it is no run.")
      .def_property_readonly("name", &Run::name, "Of the folder or file.")
      .def_property_readonly(
          "info", [](const Run& run) { return python_of(to_json(run.info())); },
          "What run.json says: version, host, started, axes with their errors and faults, settings, ...")
      .def_property_readonly("axes", &axes_of_run, "Names of the axes.")
      .def(
          "units",
          [](const Run& run, const std::optional<std::string>& axis) {
            return of_each_signal(run, axis, [](const runs::Signal& signal) { return signal.unit; });
          },
          py::arg("axis") = py::none(), "Unit of each signal, by its name; \"\": none.")
      .def(
          "words",
          [](const Run& run, const std::optional<std::string>& axis) {
            return of_each_signal(run, axis, [](const runs::Signal& signal) { return signal.words; });
          },
          py::arg("axis") = py::none(),
          "Words of each signal, by its name: state 4 is words()[\"state\"][4]. Empty for numbers.")
      .def("read", &read, py::arg("signals") = py::none(), py::kw_only(), py::arg("axis") = py::none(),
           py::arg("from_s") = py::none(), py::arg("to_s") = py::none(),
           R"(Return time_s and these signals of an axis as arrays of shape (n,), by their names.

signals: all if left out. axis: may be left out if the run has one. from_s, to_s: limits of time_s, included.
A value that a cycle does not have is NaN.
Raises Error for an unknown axis or signal, and for a row that is none, with its place.
)");
}

}  // namespace hystcan::python
