#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "app/stage/identification_report.h"
#include "app/stage/identification_result.h"
#include "base/output_file.h"
#include "base/text.h"
#include "base/words.h"
#include "config/files/actuator.h"
#include "identification/dynamics/joint_dynamics.h"
#include "identification/identify.h"
#include "python/bindings.h"

namespace hystcan::python {
namespace {

using identification::Dataset;

Dataset dataset_of(const Array& t, const Array& u, const Array& y, const std::string& input_unit,
                   const std::string& output_unit) {
  for (const auto& [name, unit] :
       {std::pair("input_unit", input_unit), std::pair("output_unit", output_unit)})
    if (has_control_character(unit))
      throw py::value_error(fmt::format("{} contains a control character, expected one line of text", name));
  Dataset dataset{.input_unit = input_unit,
                  .output_unit = output_unit,
                  .time_s = vector_of(t, "t"),
                  .input = vector_of(u, "u"),
                  .output = vector_of(y, "y")};
  const std::size_t rows = dataset.time_s.size();
  if (dataset.input.size() != rows || dataset.output.size() != rows)
    throw py::value_error(fmt::format("t, u, y have {}, {}, {} values, expected the same number of each",
                                      rows, dataset.input.size(), dataset.output.size()));
  if (rows == 0) throw py::value_error("t, u, y are empty, expected at least one value");
  for (std::size_t i = 1; i < rows; ++i)
    if (!(dataset.time_s[i] > dataset.time_s[i - 1]))
      throw py::value_error(fmt::format("t[{}] is {} after {}, expected an increasing time", i,
                                        dataset.time_s[i], dataset.time_s[i - 1]));
  return dataset;
}

/// Accepts arrays of one record, or sequences of arrays of several records.
std::vector<Dataset> datasets_of(const py::object& t, const py::object& u, const py::object& y,
                                 const std::string& input_unit, const std::string& output_unit) {
  const auto is_several = [](const py::object& given) {
    if (!py::isinstance<py::list>(given) && !py::isinstance<py::tuple>(given)) return false;
    const auto sequence = given.cast<py::sequence>();
    return sequence.size() > 0 && !py::isinstance<py::float_>(sequence[0]) &&
           !py::isinstance<py::int_>(sequence[0]) && py::hasattr(sequence[0], "__len__");
  };
  if (!is_several(t))
    return {dataset_of(t.cast<Array>(), u.cast<Array>(), y.cast<Array>(), input_unit, output_unit)};
  const auto times = t.cast<py::sequence>(), inputs = u.cast<py::sequence>(),
             outputs = y.cast<py::sequence>();
  if (inputs.size() != times.size() || outputs.size() != times.size())
    throw py::value_error(fmt::format("t, u, y have {}, {}, {} records, expected the same number of each",
                                      times.size(), inputs.size(), outputs.size()));
  std::vector<Dataset> datasets;
  for (std::size_t i = 0; i < times.size(); ++i)
    datasets.push_back(dataset_of(times[i].cast<Array>(), inputs[i].cast<Array>(), outputs[i].cast<Array>(),
                                  input_unit, output_unit));
  return datasets;
}

struct Result {
  config::Actuator model;
  py::object report;
  std::string text;
};

identification::IdentifyOptions options_of(const std::optional<int>& order,
                                           const std::optional<std::string>& symmetry,
                                           const std::string& thresholds, const std::string& curves) {
  identification::IdentifyOptions options;
  if (order) options.shape = identification::CurveShape::polynomial(*order);
  const auto choice = parse_word<identification::CurveChoice>(curves);
  if (!choice)
    throw py::value_error(
        fmt::format("curves is \"{}\", expected \"auto\", \"polynomial\" or \"spline\"", curves));
  options.curves = *choice;
  if (symmetry) {
    const auto output = parse_word<identification::ShapeOfOutput>(*symmetry);
    if (!output)
      throw py::value_error(
          fmt::format("symmetry is \"{}\", expected \"none\", \"even\" or \"butterfly\"", *symmetry));
    options.output = *output;
  }
  if (thresholds != "auto" && thresholds != "observed")
    throw py::value_error(fmt::format("thresholds is \"{}\", expected \"auto\" or \"observed\"", thresholds));
  options.observed_thresholds = thresholds == "observed";
  options.go_on = [] {
    check_signals();
    return true;
  };
  return options;
}

Result identify(const py::object& t, const py::object& u, const py::object& y,
                const std::optional<int>& order, const std::optional<std::string>& symmetry,
                const std::string& thresholds, const std::string& curves,
                const std::optional<double>& delay_s, bool common_zero, bool common_gain, bool drift,
                bool dynamics, const std::string& input_unit, const std::string& output_unit) {
  const std::vector<Dataset> datasets = datasets_of(t, u, y, input_unit, output_unit);
  if (order && (*order < 1 || *order > identification::highest_order))
    throw py::value_error(
        fmt::format("order is {}, expected 1 to {}", *order, identification::highest_order));
  identification::IdentifyOptions options = options_of(order, symmetry, thresholds, curves);
  options.delay_s = delay_s;
  options.common_zero = common_zero;
  options.common_gain = common_gain;
  options.drift = drift;
  std::optional<identification::Identified> identified;
  std::vector<std::string> finding_texts;
  {
    const Unlocked unlocked;
    identified = dynamics ? identification::identify_dynamics(datasets, options)
                          : identification::identify(datasets, options);
    finding_texts = app::findings(datasets, *identified);
  }
  return {config::Actuator::of(model::Hysteresis(identified->parameters), "identified", identified->lag()),
          python_of(app::identification_json(*identified, finding_texts)),
          app::identified_model_text(*identified, datasets, finding_texts)};
}

void save_result(const Result& result, const std::filesystem::path& path) { write_file(path, result.text); }

py::dict validate(const config::Actuator& model, const Array& t, const Array& u, const Array& y,
                  const std::optional<double>& delay_s, const std::optional<double>& estimate_from_s,
                  bool offset) {
  identification::Lag lag = model.lag;
  if (delay_s) lag.set_delay(*delay_s);
  const auto* const hysteresis = std::get_if<model::Hysteresis>(model.model.get());
  if (hysteresis == nullptr)
    throw py::value_error(fmt::format("{}: kind is {}, expected recursive-memory", model.name, model.kind()));
  const Dataset dataset = dataset_of(t, u, y, model.input_unit, model.output_unit);
  app::Validation validation;
  {
    const Unlocked unlocked;
    validation =
        app::validate(*hysteresis, dataset,
                      {.lag = lag, .estimate_s = estimate_from_s, .estimates_offset = offset, .memory = {}});
  }
  auto report = python_of(app::validation_json(validation)).cast<py::dict>();
  report["predicted"] = array_of(std::move(validation.predicted));
  return report;
}

}  // namespace

void bind_identification(py::module_& module) {
  py::class_<Result> type(module, "Identified", "Result of identify(): the model and its report.");
  forbid_new(type, "Identified cannot be created directly: call identify()");
  type.def_readonly("model", &Result::model, "The identified model.")
      .def_readonly(
          "report", &Result::report,
          "Figures and findings, like the output of `hystcan identify --json`; errors are in percent of the "
          "span.")
      .def("save", &save_result, py::arg("path"),
           R"(Write the model file, which `Model.load` and a configuration can read.

Raises OSError if the file cannot be written.
)");
  module.def("identify", &identify, py::arg("t"), py::arg("u"), py::arg("y"), py::kw_only(),
             py::arg("order") = py::none(), py::arg("symmetry") = py::none(), py::arg("thresholds") = "auto",
             py::arg("curves") = "auto", py::arg("delay_s") = py::none(), py::arg("common_zero") = false,
             py::arg("common_gain") = false, py::arg("drift") = false, py::arg("dynamics") = false,
             py::arg("input_unit") = "V", py::arg("output_unit") = "um",
             R"(Identify a model from measured records and return it with its figures.

t, u, y: time in seconds, input and output, each of shape (n,); for several records, a list of such arrays each.
order: order of polynomial reference curves; default: chosen by hold-out. curves: "auto", "polynomial" or "spline".
symmetry: "none", "even" or "butterfly"; default: identified. thresholds: "observed" uses the ends of the inputs.
delay_s: known delay in seconds; default: identified. Each record has its own zero and gain, unless common_zero or
common_gain is True. drift: True also fits a linear drift of the zero. dynamics: True also identifies a mode and a
delay that follow the hysteresis; delay_s is then that delay.
Raises ValueError if the arrays are not a record, and Error if no model can be identified. Ctrl-C raises
KeyboardInterrupt.

>>> import hystcan, numpy
>>> t = numpy.arange(8000) * 1e-3
>>> u = 50 - 50 * (1 - t / 16) * numpy.cos(7 * t)
>>> true = hystcan.Model.load(hystcan.shipped("piezo.model.toml"))
>>> found = hystcan.identify(t, u, true.simulate(u))
>>> found.report["rms_percent"] < 0.1
True
)");
  module.def(
      "validate", &validate, py::arg("model"), py::arg("t"), py::arg("u"), py::arg("y"), py::kw_only(),
      py::arg("delay_s") = py::none(), py::arg("estimate_from_s") = py::none(), py::arg("offset") = true,
      R"(Predict a record with a model and return a dict: the errors, and the prediction in "predicted".

t, u, y: one record, as in identify. delay_s: delay in seconds; default: that of the model. estimate_from_s: length
in seconds of the beginning from which the initial memory and the offset are estimated, and which the errors exclude;
default: all samples. offset: False estimates no offset.
Raises ValueError if the arrays are not a record.

>>> import hystcan, numpy
>>> model = hystcan.Model.load(hystcan.shipped("piezo.model.toml"))
>>> t = numpy.arange(2000) * 1e-3
>>> u = 50 - 45 * numpy.cos(7 * t)
>>> hystcan.validate(model, t, u, model.simulate(u))["rms_percent"] < 0.1
True
)");
}

}  // namespace hystcan::python
