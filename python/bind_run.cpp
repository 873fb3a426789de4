#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "metrics/step_response.h"
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

std::optional<py::dict> step_response(const Array& t, const Array& reference_um, const Array& position_um,
                                      double tolerance_um) {
  const metrics::Cycles cycles{
      column(t, "t"),
      gapped_column(reference_um, "reference_um"),
      gapped_column(position_um, "position_um"),
  };
  if (cycles.reference_um.size() != cycles.time_s.size() || cycles.position_um.size() != cycles.time_s.size())
    throw py::value_error(
        fmt::format("t, reference_um, position_um have {}, {}, {} values, expected the same number of each",
                    cycles.time_s.size(), cycles.reference_um.size(), cycles.position_um.size()));
  std::size_t begin = 0;
  const auto step = metrics::largest_step(cycles, tolerance_um, begin);
  if (!step) return std::nullopt;
  using py::literals::operator""_a;
  return py::dict("from_um"_a = step->from_um, "to_um"_a = step->to_um, "band_um"_a = step->band_um,
                  "begin_s"_a = step->begin_s, "rise_s"_a = step->rise_s(),
                  "settling_s"_a = step->settling_s(), "overshoot_percent"_a = 100.0 * step->overshoot());
}

}  // namespace

void bind_run(py::module_& module) {
  py::class_<Run> type(module, "Run",
                       R"(A recorded run: a folder that a controller has recorded, or a CSV file of cycles.

If the recording was interrupted or still goes on, the run is read up to its last complete row.
)");
  forbid_new(type, "Run cannot be created directly: call Run.open()");
  type.def_static(
          "open", [](const std::filesystem::path& path) { return Run(path); }, py::arg("path"),
          py::call_guard<Unlocked>(), "Open a run. Raises Error if the folder or file is not a recorded run.")
      .def_property_readonly("name", &Run::name, "Name of the folder or file.")
      .def_property_readonly(
          "info", [](const Run& run) { return python_of(to_json(run.info())); },
          "Contents of run.json: version, host, started, axes with their errors and faults, settings, ...")
      .def_property_readonly("axes", &axes_of_run, "Names of the axes.")
      .def(
          "units",
          [](const Run& run, const std::optional<std::string>& axis) {
            return of_each_signal(run, axis, [](const runs::Signal& signal) { return signal.unit; });
          },
          py::arg("axis") = py::none(),
          "Return the unit of each signal, by its name; \"\" for a signal without a unit.")
      .def(
          "words",
          [](const Run& run, const std::optional<std::string>& axis) {
            return of_each_signal(run, axis, [](const runs::Signal& signal) { return signal.words; });
          },
          py::arg("axis") = py::none(),
          "Return the words of each signal, by its name: words()[\"state\"][4] is the word for state 4. "
          "Empty for a "
          "signal of numbers.")
      .def("read", &read, py::arg("signals") = py::none(), py::kw_only(), py::arg("axis") = py::none(),
           py::arg("from_s") = py::none(), py::arg("to_s") = py::none(),
           R"(Return time_s and these signals of an axis as arrays of shape (n,), by their names.

signals: names; default: all. axis: name, optional if the run has one axis. from_s, to_s: limits of time_s, inclusive.
A value that is missing in a cycle is NaN.
Raises Error for an unknown axis or signal, and, with its place, for a row that is not valid.
)");
  module.def(
      "step_response", &step_response, py::arg("t"), py::arg("reference_um"), py::arg("position_um"),
      py::kw_only(), py::arg("tolerance_um") = 0.0,
      R"(Return the figures of the largest step of the reference, as in the controller's report and in `hystcan plot`.

tolerance_um: half-width of the settling band in um, as in [axis.control.in_position]; 0: the band is 1 % of the step.
The dict has from_um, to_um, band_um, begin_s, rise_s (10 to 90 %), settling_s and overshoot_percent. rise_s and
settling_s are None if the record ends first. A position that is NaN is ignored: set it to NaN in cycles with
sample_missing = 1, because the controller did not receive that sample.
A step leads from one level to the next. At a level, the reference is constant for ten cycles, or from the first cycle
on. A reference that is NaN separates two parts: set it to NaN in cycles with shape_time_s = 0, the transition to a
segment, which is not a step.
Returns None if there is no step.

>>> import hystcan
>>> step = hystcan.step_response(range(20), [0.0] * 5 + [2.0] * 15, [0.0] * 6 + [1.0, 2.1] + [2.0] * 12)
>>> step["settling_s"], round(step["overshoot_percent"], 6)
(3.0, 5.0)
)");
}

}  // namespace hystcan::python
