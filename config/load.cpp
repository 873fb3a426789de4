#include <variant>

#include <fmt/format.h>

#include <algorithm>

#include "config/check.h"
#include "config/model_file.h"
#include "config/schema.h"
#include "config/setpoint_file.h"

namespace hystcan::config {
namespace {

Config read_config(const Document& document) {
  Config config;
  config.file = document.file();
  config.twin.heartbeat_period = std::chrono::milliseconds(100);
  Reader reader(document, document.root(), "");
  visit(reader, config);
  reader.finish();
  return config;
}

/// What transitions keep where the file leaves a limit of the reference open.
void set_transition_limits(const Document& document, Config& config, std::size_t i) {
  controller::AxisConfig& control = config.axes[i].control;
  const controller::ReferenceLimits limits =
      controller::default_transition_limits(control.gate, control.law.model, control.delays);
  const auto is_open = [&](const char* key) {
    return !document.root().at_path(fmt::format("axis[{}].control.{}", i, key));
  };
  if (is_open("reference_slew_um_per_s")) control.transition_limits.slew_um_per_s = limits.slew_um_per_s;
  if (is_open("reference_acceleration_um_per_s2"))
    control.transition_limits.acceleration_um_per_s2 = limits.acceleration_um_per_s2;
}

/// The controller's model of axis i, and what follows from it.
void complete_control(const Document& document, Config& config, std::size_t i) {
  AxisConfig& axis = config.axes[i];
  axis.control.law.model = load_model(document.resolve(axis.control_model));
  set_transition_limits(document, config, i);
}

/// An axis's parts know what they share, and the models they name.
void complete(const Document& document, AxisConfig& axis) {
  axis.control.name = axis.wire.name;
  axis.wire.drive_unit = axis.drive_unit;
  for (controller::Segment& segment : axis.control.setpoint)
    if (auto* table = std::get_if<controller::Table>(&segment.shape))
      table->curve = load_setpoint(document.resolve(table->file));
  axis.twin.wire = axis.wire;
  axis.twin.plant.hysteresis = load_any_parameters(document.resolve(axis.twin_model));
}

/// The axes that the couplings of axis i name, at `key` ("axis[0].control.coupling").
template <class Coupling>
void resolve_couplings(const Document& document, const Config& config, std::size_t i, const std::string& key,
                       std::vector<Coupling>& couplings) {
  for (std::size_t j = 0; j < couplings.size(); ++j) {
    const auto from = std::ranges::find(config.axes, couplings[j].from,
                                        [](const AxisConfig& axis) { return axis.wire.name; });
    if (from == config.axes.end() || from->wire.name == config.axes[i].wire.name)
      document.fail_at(fmt::format("{}[{}].from", key, j),
                       fmt::format("from is \"{}\", expected the name of another axis", couplings[j].from));
    couplings[j].index = static_cast<std::size_t>(from - config.axes.begin());
  }
}

/// A free-running sensor samples, by its own clock, once a cycle.
void set_sample_rate(const Config& config, twin::SampleClock& clock) {
  if (clock.rate_Hz == 0.0) clock.rate_Hz = config.controller.rate_Hz;
}

/// The axes that the others' couplings name.
void resolve_couplings(const Document& document, Config& config) {
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    AxisConfig& axis = config.axes[i];
    resolve_couplings(document, config, i, fmt::format("axis[{}].control.coupling", i),
                      axis.control.couplings);
    resolve_couplings(document, config, i, fmt::format("axis[{}].twin.coupling", i), axis.twin.couplings);
  }
}

}  // namespace

Config load(const std::filesystem::path& file, const std::vector<Setting>& overrides) {
  const Document document(file, overrides);
  Config config = read_config(document);
  config.database = can::load_dbc(document.resolve(config.bus.dbc));
  resolve_couplings(document, config);
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    AxisConfig& axis = config.axes[i];
    complete_control(document, config, i);
    complete(document, axis);
    set_sample_rate(config, axis.twin.sample_clock);
    config.controller.axes.push_back(
        {.wire = axis.wire, .axis = axis.control, .live_setpoint = axis.live_setpoint});
    config.twin.axes.push_back(axis.twin);
  }
  std::filesystem::path& black_boxes = config.controller.black_box.folder;
  if (!black_boxes.empty()) black_boxes = document.resolve(black_boxes);
  std::filesystem::path& states = config.controller.state_folder;
  if (!states.empty()) states = document.resolve(states);
  std::string& socket = config.controller.control_socket;
  if (!socket.empty() && socket != "none") socket = document.resolve(socket).string();
  check_agreement(document, config);
  return config;
}

std::string echo(const std::filesystem::path& file, const std::vector<Setting>& overrides) {
  const Document document(file, overrides);
  Config config = read_config(document);
  for (std::size_t i = 0; i < config.axes.size(); ++i) complete_control(document, config, i);
  Writer writer(document);
  visit(writer, config);
  return writer.text();
}

}  // namespace hystcan::config
