#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "app/stage/identification_result.h"
#include "base/output_file.h"
#include "config/files/actuator.h"
#include "python/bindings.h"

namespace hystcan::python {
namespace {

using Model = config::Actuator;
using Memory = config::ActuatorMemory;
using config::Pass;

/// Issues a RuntimeWarning, which a notebook shows once and a test can turn into an error.
void warn_of(const Pass& pass, const char* what, const Model& model) {
  std::string text;
  if (pass.tally.saturated > 0)
    text = fmt::format("{} of {} {} are out of range and were limited", pass.tally.saturated,
                       pass.outputs.size(), what);
  if (pass.tally.not_increasing > 0)
    text += fmt::format("{}{} of {} values are on a branch that does not increase", text.empty() ? "" : "; ",
                        pass.tally.not_increasing, pass.outputs.size());
  if (text.empty()) return;
  if (PyErr_WarnEx(PyExc_RuntimeWarning, fmt::format("{}: {}", model.name, text).c_str(), 2) != 0)
    throw py::error_already_set();
}

using Times = std::optional<Array>;

/// Returns the times of `size` rows, which start at this memory; empty if no times are given, which is
/// allowed for a model without creep.
std::span<const double> times_of(const Model& model, const Memory& memory, const Times& t, std::size_t size) {
  if (!t && model.lag.creep)
    throw py::value_error(
        model.name +
        ": the model has creep, expected the times t; or use quasi_static(), the model without creep");
  if (!t) return {};
  const auto times = column(*t, "t");
  if (times.size() != size)
    throw py::value_error(
        fmt::format("t has {} values, expected {}, one for each value", times.size(), size));
  std::optional<double> before_s = memory.time_s();
  for (std::size_t i = 0; i < size; ++i) {
    if (before_s && !(times[i] > *before_s))
      throw py::value_error(
          fmt::format("t[{}] is {} after {}, expected an increasing time", i, times[i], *before_s));
    before_s = times[i];
  }
  return times;
}

/// Runs `work(memory, times)` on the given memory, which it advances, or on a new one.
template <class Work>
py::array_t<double> run(const Model& model, Memory* memory, const Times& t, const char* what,
                        std::size_t size, Work work) {
  if (memory != nullptr && memory->model() != model.model)
    throw py::value_error("the memory belongs to another model, expected a memory of this model");
  std::optional<Memory> fresh;
  Memory& state = memory != nullptr ? *memory : fresh.emplace(model.memory());
  const auto times = times_of(model, state, t, size);
  Pass pass;
  {
    const Unlocked unlocked;
    pass = work(state, times);
  }
  warn_of(pass, what, model);
  return array_of(std::move(pass.inputs.empty() ? pass.outputs : pass.inputs));
}

py::array_t<double> simulate(const Model& model, const Array& u, Memory* memory, const Times& t) {
  const auto inputs = column(u, "u");
  return run(model, memory, t, "inputs", inputs.size(),
             [&](Memory& state, std::span<const double> times) { return state.simulate(inputs, times); });
}

py::array_t<double> inverse(const Model& model, const Array& y, Memory* memory, const Times& t,
                            bool negative_drive) {
  const auto outputs = column(y, "y");
  if (negative_drive && !model.is_even())
    throw py::value_error(model.name + ": symmetry is \"none\", expected \"even\" for negative_drive");
  return run(model, memory, t, "outputs", outputs.size(), [&](Memory& state, std::span<const double> times) {
    return state.inverse(outputs, times, negative_drive ? -1.0 : 1.0);
  });
}

std::pair<double, double> pair_of(const model::Interval& interval) { return {interval.lo, interval.hi}; }

double step_memory(Memory& memory, double u, const std::optional<double>& t) {
  if (!std::isfinite(u)) throw py::value_error(fmt::format("u is {}, expected a finite number", u));
  if (!t && memory.creeps()) throw py::value_error("the model has creep, expected the time t of the input");
  const double time_s = t.value_or(0.0);
  if (!std::isfinite(time_s)) throw py::value_error(fmt::format("t is {}, expected a finite number", time_s));
  if (const auto before_s = memory.time_s(); before_s && !(time_s > *before_s))
    throw py::value_error(fmt::format("t is {} after {}, expected an increasing time", time_s, *before_s));
  return memory.simulate({&u, 1}, {&time_s, 1}).outputs[0];
}

void save_memory(const Memory& memory, const std::filesystem::path& path) { write_file(path, memory.text()); }

void bind_memory(py::module_& module) {
  py::class_<Memory> type(module, "Memory",
                          R"(The memory of an actuator: the state that determines, with the input, its output.

A copy is independent: a trial on a copy does not change the original.

>>> import hystcan
>>> memory = hystcan.Model.load(hystcan.shipped("piezo.model.toml")).memory()
>>> y = [memory.step(u) for u in (0.0, 80.0, 20.0)]
>>> memory.turning_inputs
array([80.])
)");
  forbid_new(type, "Memory cannot be created directly: call Model.memory() or Model.load_memory()");
  type.def("step", &step_memory, py::arg("u"), py::arg("t") = py::none(),
           R"(Apply one input, in input units, and return the output, in output units.

t: time of the input in seconds, required for a model with creep; must increase from step to step.
Raises ValueError if `u` or `t` is not finite. An input beyond the thresholds is limited to them.

>>> import hystcan
>>> memory = hystcan.Model.load(hystcan.shipped("piezo.model.toml")).memory()
>>> memory.step(50.0) < memory.step(60.0)
True
)")
      .def(
          "copy", [](const Memory& memory) { return memory; }, "Return an independent copy.")
      .def("__copy__", [](const Memory& memory) { return memory; })
      .def("__deepcopy__", [](const Memory& memory, const py::dict&) { return memory; })
      .def("save", &save_memory, py::arg("path"),
           R"(Write the memory as TOML; `Model.load_memory` restores it exactly.

Raises OSError if the file cannot be written.
)")
      .def_property_readonly("input", &Memory::input, "The present input, in input units.")
      .def_property_readonly("output", &Memory::output, "The present output, in output units.")
      .def_property_readonly("time_s", &Memory::time_s,
                             "Time of the last input in seconds if the model has creep; otherwise None.")
      .def_property_readonly(
          "turning_inputs", [](const Memory& memory) { return array_of(memory.turning_inputs()); },
          "Inputs at the remembered turning points, oldest first; shape (n,). Empty for play operators.");
}

}  // namespace

void bind_model(py::module_& module) {
  bind_memory(module);
  py::class_<Model> type(module, "Model", R"(A hysteresis model of any kind, with its exact inverse.

>>> import hystcan, numpy
>>> model = hystcan.Model.load(hystcan.shipped("piezo.model.toml"))
>>> u = 50 + 40 * numpy.sin(numpy.linspace(0, 6, 1000))
>>> y = model.simulate(u)
>>> bool(numpy.abs(model.inverse(y) - u).max() < 1e-9)
True
)");
  forbid_new(type, "a Model comes from Model.load() or identify()");
  type.def_static("load", &Model::load, py::arg("path"), py::kw_only(), py::arg("beyond_limit") = false,
                  R"(Read a model file (TOML).

beyond_limit: True accepts a model with branches that do not increase, for study; it has no exact inverse.
Raises Error, with the place in the file, if the file is not a valid model file.

>>> import hystcan
>>> hystcan.Model.load(hystcan.shipped("piezo.model.toml")).kind
'recursive-memory'
)")
      .def("simulate", &simulate, py::arg("u"), py::arg("memory") = py::none(), py::kw_only(),
           py::arg("t") = py::none(),
           R"(Return the outputs for the inputs u, shape (n,), in output units.

memory: initial state of the actuator, which is advanced to the last input; default: on the ascending reference curve
at the lower threshold.
t: times of the inputs in seconds, required for a model with creep. Each input is held until the next time. The creep
starts settled at the first input, or from the state in `memory`.
Raises ValueError if u is not one-dimensional or not finite, or if t does not increase. Warns if inputs exceed the
thresholds.

>>> import hystcan
>>> model = hystcan.Model.load(hystcan.shipped("piezo.model.toml"))
>>> model.simulate([0.0, 50.0, 100.0, 50.0]).round(3)[[1, 3]]
array([13.35, 17.85])
)")
      .def("inverse", &inverse, py::arg("y"), py::arg("memory") = py::none(), py::kw_only(),
           py::arg("t") = py::none(), py::arg("negative_drive") = false,
           R"(Return the inputs that produce the outputs y, shape (n,), in input units.

memory, t: as in simulate. negative_drive: True returns the negative of the two inputs of an even model.
Raises ValueError if y is not one-dimensional or not finite, or if t does not increase. Warns if the model cannot reach
an output.

>>> import hystcan
>>> model = hystcan.Model.load(hystcan.shipped("piezo.model.toml"))
>>> model.simulate(model.inverse([10.0, 20.0, 15.0])).round(9)
array([10., 20., 15.])
)")
      .def(
          "output_range",
          [](const Model& model, const Memory* memory) {
            return pair_of(memory != nullptr ? memory->reachable() : model.memory().reachable());
          },
          py::arg("memory") = py::none(),
          R"(Return the lowest and highest output that one input can reach from this memory.

>>> import hystcan
>>> lowest, highest = hystcan.Model.load(hystcan.shipped("piezo.model.toml")).output_range()
>>> round(highest, 9)
30.0
)")
      .def(
          "memory", [](const Model& model) { return model.memory(); },
          "Return a new Memory, on the ascending reference curve at the lower threshold.")
      .def(
          "load_memory",
          [](const Model& model, const std::filesystem::path& path) {
            Memory memory = model.memory();
            memory.load(path);
            return memory;
          },
          py::arg("path"),
          R"(Read a memory that Memory.save or `hystcan simulate --save-memory` has written.

Raises Error, with the place in the file, if the file is not valid or belongs to another model.
)")
      .def("quasi_static", &Model::quasi_static,
           "Return a copy with the hysteresis alone, without creep and dynamics; it needs no times.")
      .def_property_readonly("kind", &Model::kind,
                             "Kind of the model, as in the model file: \"recursive-memory\", ...")
      .def_property_readonly(
          "input_range", [](const Model& model) { return pair_of(model.input_range()); },
          "The thresholds (lower, upper), in input units.")
      .def_readonly("input_unit", &Model::input_unit, "Unit of the input, as in the model file: \"V\".")
      .def_readonly("output_unit", &Model::output_unit, "Unit of the output, as in the model file: \"um\".")
      .def_property_readonly(
          "delay_s", [](const Model& model) { return model.lag.delay_s; },
          "Delay of the output in seconds, if it was identified with the model; otherwise 0.")
      .def_property_readonly(
          "dynamics", [](const Model& model) { return python_of(app::json_of(model.lag.dynamics)); },
          "Mode and delay that follow the hysteresis, [dynamics] of the model file: a dict or None.")
      .def_property_readonly(
          "creep", [](const Model& model) { return python_of(app::json_of(model.lag.creep)); },
          "Creep that follows the hysteresis, [creep] of the model file: a dict or None.")
      .def("__repr__", [](const Model& model) {
        const model::Interval range = model.input_range();
        return fmt::format("<hystcan.Model {} {}, {:g} to {:g} {}>", model.name, model.kind(), range.lo,
                           range.hi, model.input_unit);
      });
}

}  // namespace hystcan::python
