#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "app/live/control_protocol.h"
#include "app/live/live_config.h"
#include "app/live/rehearsal_setup.h"
#include "base/error.h"
#include "config/schema/config.h"
#include "controller/cycle_record.h"
#include "controller/reference/motion.h"
#include "controller/requests.h"
#include "python/bindings.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::python {
namespace {

constexpr double longest_s = 1e6;
constexpr double start_up_limit_s = 60.0;  // longer than any start-up

can::Duration duration_of(double time_s) {
  return std::chrono::ceil<can::Duration>(std::chrono::duration<double>(time_s));
}

/// Loads the configuration. `references`: by axis name; each replaces the configured reference and is
/// followed once. Throws Error.
config::Config configuration(const std::filesystem::path& file, const std::vector<config::Setting>& overrides,
                             const std::map<std::string, controller::MonotoneCubic>& references,
                             const config::ReadFiles& files) {
  config::Config config = config::load(file, overrides, files);
  for (const auto& [name, curve] : references) {
    const auto axis =
        std::ranges::find_if(config.axes, [&](const auto& each) { return each.wire.name == name; });
    if (axis == config.axes.end())
      throw Error(file, fmt::format("a reference is given for the unknown axis {}", name),
                  expect("one of {}", fmt::join(config::axis_names(config), ", ")));
    const controller::MotionBounds range = curve.bounds();
    const auto& supervision = axis->control.supervision;
    if (range.lowest_um < supervision.position_min_um || range.highest_um > supervision.position_max_um)
      throw Error(fmt::format("the reference of axis {} ranges from {:g} to {:g} um", name, range.lowest_um,
                              range.highest_um),
                  expect("{:g} to {:g} um", supervision.position_min_um, supervision.position_max_um));
    axis->control.setpoint.assign(1, {.shape = controller::Table{.file = "reference", .curve = curve}});
    axis->control.repeat = false;
  }
  return config;
}

/// A rehearsal that runs step by step, stores every cycle, and accepts the commands of a control socket.
class VirtualStage {
 public:
  VirtualStage(const std::filesystem::path& file, config::Config config, config::ReadFiles files)
      : config_(std::move(config)),
        live_(file, config_, std::move(files)),
        columns_(config_.axes.size(),
                 std::vector<std::vector<double>>(controller::cycle_columns().size() + 1)),
        true_um_(config_.axes.size()),
        tracks_since_s_(config_.axes.size()),
        loop_(app::rehearsal_setup(config_),
              [this](const controller::CycleRecord& record) { take(record); }) {
    for (const config::AxisConfig& axis : config_.axes)
      lengths_s_.push_back(controller::reference_of(axis.control).length_s());
    loop_.controller().listen_to(requests_);
    loop_.twin().on_truth([this](const twin::Truth& truth) { true_um_.at(truth.axis) = truth.position_um; });
    loop_.start();
  }

  const std::vector<std::string>& axes() const { return live_.axis_names(); }
  double time_s() const { return loop_.time_s(); }

  /// Runs in short pieces, so that Ctrl-C can interrupt it.
  void run_until(double end_s) {
    constexpr auto piece = std::chrono::milliseconds(500);
    for (double left_s = end_s - time_s(); left_s > 0.0; left_s = end_s - time_s()) {
      check_signals();
      loop_.run_for(std::min<can::Duration>(piece, duration_of(left_s)));
    }
  }

  /// Runs until every axis has finished its reference once, an axis faults, or no axis starts to track in
  /// time.
  void run_to_the_end() {
    const double deadline_s = time_s() + start_up_limit_s + std::ranges::max(lengths_s_);
    while (!is_over() && time_s() < deadline_s) run_until(time_s() + 0.01);
  }

  /// Returns the columns of every cycle so far.
  py::dict signals(const std::optional<std::string>& axis) const {
    if (!axis && axes().size() != 1)
      throw Error(fmt::format("axis is missing, and the configuration has {} axes", axes().size()),
                  expect("one of {}", fmt::join(axes(), ", ")));
    const auto& columns = columns_[axis ? live_.axis_index(*axis) : 0];
    py::dict signals;
    std::size_t i = 0;
    for (const controller::CycleColumn& column : controller::cycle_columns()) {
      if (column.kind != controller::CycleColumn::Kind::axis)
        signals[py::str(column.name)] = array_of(columns[i]);
      ++i;
    }
    signals["true_position_um"] = array_of(columns[i]);
    return signals;
  }

  std::map<std::string, std::string> status() {
    std::map<std::string, std::string> states;
    for (std::size_t i = 0; i < axes().size(); ++i) {
      const controller::AxisReport& report = loop_.controller().axis(i).report();
      states[axes()[i]] = report.cause == controller::Cause::none
                              ? std::string(to_string(report.state))
                              : fmt::format("{}: {}", to_string(report.state), to_string(report.cause));
    }
    return states;
  }

  // Both functions run the few cycles until the answers. They throw Error if a request is refused.

  void set(const std::string& axis, const std::string& key, const std::string& toml_value) {
    app::LiveConfig::Prepared prepared = live_.with(axis, key, toml_value);
    if (!prepared.after_restart.empty())
      throw Error(fmt::format("this key cannot be changed while the rehearsal runs: {}",
                              describe(prepared.after_restart.front())),
                  {.remedy = "set it in `settings` of a new Rehearsal"});
    ask_all(std::move(prepared.requests));
    live_.accept(prepared);
  }

  void ask(controller::Request::Kind kind, const std::optional<std::string>& axis, double position_um) {
    std::vector<std::unique_ptr<controller::Request>> requests;
    for (std::size_t i = 0; i < axes().size(); ++i) {
      if (axis && live_.axis_index(*axis) != i) continue;
      requests.push_back(std::make_unique<controller::Request>());
      requests.back()->kind = kind;
      requests.back()->axis = i;
      requests.back()->position_um = position_um;
    }
    ask_all(std::move(requests));
  }

 private:
  void take(const controller::CycleRecord& record) {
    auto& columns = columns_[record.axis];
    std::size_t i = 0;
    for (const controller::CycleColumn& column : controller::cycle_columns())
      columns[i++].push_back(column.value(record));
    columns[i].push_back(true_um_[record.axis]);
    if (record.report.state == controller::AxisState::tracking && !tracks_since_s_[record.axis])
      tracks_since_s_[record.axis] = record.time_s;
  }

  bool is_over() {
    bool have_finished = true;
    for (std::size_t i = 0; i < axes().size(); ++i) {
      if (loop_.controller().axis(i).state() == controller::AxisState::faulted) return true;
      have_finished = have_finished && tracks_since_s_[i] && time_s() >= *tracks_since_s_[i] + lengths_s_[i];
    }
    return have_finished;
  }

  void ask_all(std::vector<std::unique_ptr<controller::Request>> requests) {
    std::size_t open = requests.size();
    for (auto& request : requests) requests_.ask(std::move(request));
    const double deadline_s = time_s() + 1.0;
    std::vector<std::string> refusals;
    while (open > 0 && time_s() < deadline_s) {
      loop_.run_for(duration_of(1.0 / config_.controller.rate_Hz));
      for (auto answer = requests_.take_answer(); answer; answer = requests_.take_answer(), --open)
        if (answer->refusal)
          refusals.push_back(fmt::format("{}: {}", axes().at(answer->axis), to_string(*answer->refusal)));
    }
    if (open > 0)
      refusals.emplace_back(
          "no answer from the controller within 1 s: it has not started yet, or it has ended");
    if (!refusals.empty()) throw Error(fmt::format("{}", fmt::join(refusals, "; ")));
  }

  config::Config config_;
  app::LiveConfig live_;
  std::vector<std::vector<std::vector<double>>> columns_;  ///< [axis][column]
  std::vector<double> true_um_;                            ///< newest value of each axis
  controller::RequestLink requests_;
  std::vector<std::optional<double>> tracks_since_s_;
  std::vector<double> lengths_s_;  ///< duration of one pass of each reference
  rehearsal::Rehearsal loop_;
};

std::string toml_of(const py::object& value) {
  return py::module_::import("json").attr("dumps")(value).cast<std::string>();
}

/// The object held by Python. If Python creates it without __init__, its memory is zeroed: it has no stage.
class Rehearsal {
 public:
  static void* operator new(std::size_t size) {
    void* const zeroed = std::calloc(1, size);
    if (zeroed == nullptr) throw std::bad_alloc();
    return zeroed;
  }
  static void operator delete(void* object) { std::free(object); }

  explicit Rehearsal(std::unique_ptr<VirtualStage> stage) : stage_(std::move(stage)) {}

  /// Protects one call. Throws if there is no stage, or if another thread is in a call.
  class Use {
   public:
    explicit Use(Rehearsal& of) : of_(of) {
      if (of.stage_ == nullptr)
        throw py::type_error(
            "Rehearsal.__init__ was not called: call it first in the __init__ of the subclass");
      if (of.is_in_use_.exchange(true))
        throw std::runtime_error("another thread is using this Rehearsal: call it from one thread at a time");
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
  config::ReadFiles files;
  config::Config loaded = configuration(config, overrides, references, files);
  return std::make_unique<Rehearsal>(
      std::make_unique<VirtualStage>(config, std::move(loaded), std::move(files)));
}

void step(VirtualStage& stage, double duration_s) {
  if (!(duration_s >= 0.0 && duration_s <= longest_s))
    throw py::value_error(fmt::format("duration_s is {}, expected 0 to 1e6 s", duration_s));
  const Unlocked unlocked;
  stage.run_until(stage.time_s() + duration_s);
}

py::dict run_stage(Rehearsal& rehearsal, const std::optional<double>& duration_s) {
  const Rehearsal::Use stage(rehearsal);
  if (duration_s) {
    step(*stage, *duration_s);
  } else {
    const Unlocked unlocked;
    stage->run_to_the_end();
  }
  py::dict result;
  for (const std::string& axis : stage->axes()) result[axis.c_str()] = stage->signals(axis);
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
  py::class_<Rehearsal> bound(
      module, "Rehearsal",
      R"(Run the controller and the twin of a configuration in virtual time, as `hystcan demo` does.

The nodes are the same as in the two processes, and exchange the same frames. Time advances only in run() and step(), a
few hundred times faster than real time. Settings can be changed between two steps.

>>> import hystcan
>>> stage = hystcan.Rehearsal(hystcan.shipped("piezo.toml"))
>>> before = stage.step(3.0)
>>> stage.set("x", "kp", 0.1)
>>> stage.step(0.5)
>>> x = stage.signals("x")
>>> x["time_s"].size == x["position_um"].size
True
)");
  bound
      .def(py::init(&make), py::arg("config"), py::kw_only(),
           py::arg("settings") = std::map<std::string, py::object>{},
           py::arg("reference") = std::map<std::string, std::pair<Array, Array>>{},
           R"(settings: values that replace those of the configuration, by key: {"axis[0].control.kp": 0.1}.

reference: references that replace the configured ones, by axis name, each followed once: (t, y) in seconds and um, of
shape (n,), interpolated by a monotone cubic.
Raises Error if the configuration is not valid.
)")
      .def(
          "run", &run_stage, py::arg("duration_s") = py::none(),
          R"(Run for duration_s seconds; default: until every axis has finished its reference once, or one axis faults.

Returns the signals of each axis since the start: run()["x"]["position_um"].
)")
      .def(
          "step", [](Rehearsal& stage, double duration_s) { step(*Rehearsal::Use(stage), duration_s); },
          py::arg("duration_s"), "Run for this virtual time, in seconds.")
      .def(
          "signals",
          [](Rehearsal& stage, const std::optional<std::string>& axis) {
            return Rehearsal::Use(stage)->signals(axis);
          },
          py::arg("axis") = py::none(),
          R"(Return the columns of all cycles since the start, as arrays of shape (n,), by their names.

The columns are those of `controller --csv`, and true_position_um, the twin's position at the sample. A value that is
missing in a cycle is NaN. axis: name, optional if the configuration has one axis.
)")
      .def(
          app::row_of(app::Verb::set).word.data(),
          [](Rehearsal& stage, const std::string& axis, const std::string& key, const py::object& value) {
            Rehearsal::Use(stage)->set(axis, key, toml_of(value));
          },
          py::arg("axis"), py::arg("key"), py::arg("value"),
          R"(Change a key of [axis.control] between two cycles, as `hystcan ctl set` does.

Raises Error if the key cannot be changed during a run, or if the value is not valid.
)")
      .def(
          app::row_of(app::Verb::go_to).word.data(),
          [](Rehearsal& stage, const std::string& axis, double position_um) {
            ask(stage, Kind::go_to, axis, position_um);
          },
          py::arg("axis"), py::arg("position_um"),
          "Leave the reference and move to a position, in um. Raises Error if the controller refuses it.")
      .def(
          "status", [](Rehearsal& stage) { return Rehearsal::Use(stage)->status(); },
          "Return the state of each axis: {\"x\": \"tracking\"}; for a fault, with its cause.")
      .def_property_readonly(
          "axes", [](Rehearsal& stage) { return Rehearsal::Use(stage)->axes(); }, "Names of the axes.")
      .def_property_readonly(
          "time_s", [](Rehearsal& stage) { return Rehearsal::Use(stage)->time_s(); },
          "Virtual time since the start, in seconds.");
  const std::pair<app::Verb, const char*> acts[]{
      {app::Verb::resume, "Follow the reference again."},
      {app::Verb::enable, "Start the axis: from offline to tracking."},
      {app::Verb::disable, "Ramp to the safe drive and switch off."},
      {app::Verb::clear, "Clear the latched fault."}};
  for (const auto& [verb, meaning] : acts)
    bound.def(
        app::row_of(verb).word.data(),
        [kind = *app::row_of(verb).act](Rehearsal& stage, const std::optional<std::string>& axis) {
          ask(stage, kind, axis);
        },
        py::arg("axis") = py::none(), meaning);
}

}  // namespace hystcan::python
