#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <atomic>
#include <cstdlib>
#include <map>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "python/arrays.h"
#include "python/bindings.h"
#include "python/unlocked.h"
#include "python/virtual_stage.h"

namespace hystcan::python {
namespace {

std::string toml_of(const py::object& value) {
  return py::module_::import("json").attr("dumps")(value).cast<std::string>();
}

/// What Python holds. An object that Python makes without __init__ has the memory of one, which is zeroed: it has no
/// stage.
class Rehearsal {
 public:
  static void* operator new(std::size_t size) {
    void* const zeroed = std::calloc(1, size);
    if (zeroed == nullptr) throw std::bad_alloc();
    return zeroed;
  }
  static void operator delete(void* object) { std::free(object); }

  explicit Rehearsal(std::unique_ptr<VirtualStage> stage) : stage_(std::move(stage)) {}

  /// For the time of one call. Throws if there is no stage, or if another thread is in a call.
  class Use {
   public:
    explicit Use(Rehearsal& of) : of_(of) {
      if (of.stage_ == nullptr) throw py::type_error("Rehearsal.__init__ was not called");
      if (of.is_in_use_.exchange(true)) throw std::runtime_error("another thread uses this Rehearsal");
    }
    ~Use() { of_.is_in_use_ = false; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    VirtualStage* operator->() const { return of_.stage_.get(); }
    VirtualStage& operator*() const { return *of_.stage_; }

   private:
    Rehearsal& of_;
  };

 private:
  std::unique_ptr<VirtualStage> stage_;
  std::atomic<bool> is_in_use_ = false;
};

std::unique_ptr<Rehearsal> make(const std::filesystem::path& config,
                                const std::map<std::string, py::object>& settings,
                                const std::map<std::string, std::pair<Array, Array>>& reference) {
  std::vector<config::Setting> overrides;
  for (const auto& [key, value] : settings) overrides.push_back({key, toml_of(value)});
  std::map<std::string, controller::MonotoneCubic> references;
  for (const auto& [axis, points] : reference)
    references.emplace(
        axis, controller::MonotoneCubic(vector_of(points.first, "t"), vector_of(points.second, "y")));
  return std::make_unique<Rehearsal>(std::make_unique<VirtualStage>(config, overrides, references));
}

py::dict signals_of(const VirtualStage& stage, const std::optional<std::string>& axis) {
  py::dict result;
  for (auto& [name, values] : stage.signals(axis)) result[name.c_str()] = array_of(std::move(values));
  return result;
}

py::dict signals(Rehearsal& rehearsal, const std::optional<std::string>& axis) {
  return signals_of(*Rehearsal::Use(rehearsal), axis);
}

/// In pieces, so that Ctrl-C ends it.
void step(VirtualStage& stage, double duration_s) {
  if (!(duration_s >= 0.0 && duration_s <= VirtualStage::longest_s))
    throw py::value_error("duration_s is out of range, expected 0 to 1e6");
  const Unlocked unlocked;
  stage.run_until(stage.time_s() + duration_s, check_signals);
}

void step_stage(Rehearsal& rehearsal, double duration_s) { step(*Rehearsal::Use(rehearsal), duration_s); }

py::dict run_stage(Rehearsal& rehearsal, const std::optional<double>& duration_s) {
  const Rehearsal::Use stage(rehearsal);
  if (duration_s) {
    step(*stage, *duration_s);
  } else {
    const Unlocked unlocked;
    stage->run_to_the_end(check_signals);
  }
  py::dict result;
  for (const std::string& axis : stage->axes()) result[axis.c_str()] = signals_of(*stage, axis);
  return result;
}

using Kind = controller::Request::Kind;

void ask(Rehearsal& rehearsal, Kind kind, const std::optional<std::string>& axis, double position_um = 0.0) {
  const Rehearsal::Use stage(rehearsal);
  const Unlocked unlocked;
  stage->ask(kind, axis, position_um);
}

}  // namespace

void bind_rehearsal(py::module_& module) {
  py::class_<Rehearsal>(module, "Rehearsal",
                        R"(Controller and twin of a configuration in virtual time, as in `hystcan demo`.

The same nodes as in the two processes exchange the same frames. Time moves only in run() and step(), some hundred times
faster than the clock; settings can be changed between two steps.

>>> import hystcan
>>> stage = hystcan.Rehearsal(hystcan.shipped("piezo.toml"))
>>> before = stage.step(3.0)
>>> stage.set("x", "kp", 0.1)
>>> stage.step(0.5)
>>> x = stage.signals("x")
>>> x["time_s"].size == x["position_um"].size
True
)")
      .def(py::init(&make), py::arg("config"), py::kw_only(),
           py::arg("settings") = std::map<std::string, py::object>{},
           py::arg("reference") = std::map<std::string, std::pair<Array, Array>>{},
           R"(settings: keys of the configuration with other values, {"axis[0].control.kp": 0.1}.

reference: for an axis, by its name, (t, y) to follow once instead of the configured reference: seconds and um, each of
shape (n,), joined by a monotone cubic.
Raises Error for a configuration that the controller refuses.
)")
      .def("run", &run_stage, py::arg("duration_s") = py::none(),
           R"(Run for a time, or until every axis has finished its reference once, or one faults.

Returns the signals of each axis so far: run()["x"]["position_um"].
)")
      .def("step", &step_stage, py::arg("duration_s"), "Run for this virtual time, in seconds.")
      .def("signals", &signals, py::arg("axis") = py::none(),
           R"(Return the columns of every cycle so far, as arrays of shape (n,), by their names.

They are those of `controller --csv`, and true_position_um, the twin's position at the sample. A value that a cycle does
not have is NaN. axis: may be left out if there is one.
)")
      .def(
          "set",
          [](Rehearsal& stage, const std::string& axis, const std::string& key, const py::object& value) {
            Rehearsal::Use(stage)->set(axis, key, toml_of(value));
          },
          py::arg("axis"), py::arg("key"), py::arg("value"),
          R"(Change a key of [axis.control] between two cycles, as `hystcan ctl set` does.

Raises Error if the key needs a restart, or if the value is refused.
)")
      .def(
          "go_to",
          [](Rehearsal& stage, const std::string& axis, double position_um) {
            ask(stage, Kind::go_to, axis, position_um);
          },
          py::arg("axis"), py::arg("position_um"),
          "Leave the reference and move to a position. Raises Error if refused.")
      .def(
          "resume",
          [](Rehearsal& stage, const std::optional<std::string>& axis) { ask(stage, Kind::resume, axis); },
          py::arg("axis") = py::none(), "Follow the reference again.")
      .def(
          "enable",
          [](Rehearsal& stage, const std::optional<std::string>& axis) { ask(stage, Kind::enable, axis); },
          py::arg("axis") = py::none())
      .def(
          "disable",
          [](Rehearsal& stage, const std::optional<std::string>& axis) { ask(stage, Kind::disable, axis); },
          py::arg("axis") = py::none(), "Ramp to the safe drive and switch off.")
      .def(
          "clear",
          [](Rehearsal& stage, const std::optional<std::string>& axis) { ask(stage, Kind::clear, axis); },
          py::arg("axis") = py::none(), "Clear the latched fault.")
      .def(
          "status", [](Rehearsal& stage) { return Rehearsal::Use(stage)->status(); },
          "State of each axis, in words: {\"x\": \"tracking\"}; a fault has its cause.")
      .def_property_readonly(
          "axes", [](Rehearsal& stage) { return Rehearsal::Use(stage)->axes(); }, "Names of the axes.")
      .def_property_readonly(
          "time_s", [](Rehearsal& stage) { return Rehearsal::Use(stage)->time_s(); },
          "Virtual time since the start.");
}

}  // namespace hystcan::python
