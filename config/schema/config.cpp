#include "config/schema/config.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>

#include "config/files/csv.h"
#include "config/files/model_file.h"
#include "config/schema/check.h"
#include "config/schema/schema.h"
#include "model/any_model.h"
#include "model/hysteresis_parameters.h"

namespace hystcan::config {
namespace {

/// The file that the key at `path` names. If it cannot be read, the message has the place of the key.
std::filesystem::path named_file(const Document& document, const std::string& path,
                                 const std::filesystem::path& name) {
  std::filesystem::path file = document.resolve(name);
  std::error_code ignored;
  const std::string key = path.substr(path.rfind('.') + 1);
  if (std::filesystem::is_directory(file, ignored))
    document.fail_at(path, fmt::format("{}: {} is a folder, expected a file", key, file.string()));
  if (::access(file.c_str(), R_OK) == 0) return file;
  const int error = errno;
  if (error == ENOENT) document.fail_at(path, fmt::format("{}: no such file: {}", key, file.string()));
  document.fail_at(path, fmt::format("{}: {} cannot be read: {}", key, file.string(),
                                     std::generic_category().message(error)));
}

/// A CRC whose polynomial the file leaves out has the one that goes with the length of its message.
void choose_polynomials(const Document& document, Config& config) {
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    const auto choose = [&](const char* frame, can::MessageMap& map) {
      const can::Message* message = config.database.find(map.message);
      if (message != nullptr &&
          !document.root().at_path(fmt::format("axis[{}].frames.{}.polynomial", i, frame)))
        map.polynomial = can::usual_crc(message->length);
    };
    auto& frames = config.axes[i].wire.frames;
    if (!frames) continue;
    choose("command", frames->command);
    if (frames->status) choose("status", *frames->status);
    choose("sample", frames->sample);
  }
}

/// With the messages of its DBC.
Config read_config(const Document& document) {
  Config config;
  config.file = document.file();
  config.twin.heartbeat_period = std::chrono::milliseconds(100);
  Reader reader(document, document.root(), "");
  visit(reader, config);
  reader.finish();
  config.database = can::load_dbc(named_file(document, "bus.dbc", config.bus.dbc));
  choose_polynomials(document, config);
  return config;
}

/// A limit of the reference that the file leaves out: transitions have one of their own, which derive() sets.
void open_transition_limits(const Document& document, Config& config, std::size_t i) {
  controller::ReferenceLimits& limits = config.axes[i].control.transition_limits;
  const auto is_open = [&](const char* key) {
    return !document.root().at_path(fmt::format("axis[{}].control.{}", i, key));
  };
  if (is_open("reference_slew_um_per_s")) limits.slew_um_per_s = 0.0;
  if (is_open("reference_acceleration_um_per_s2")) limits.acceleration_um_per_s2 = 0.0;
}

/// The turnarounds of a shape spare the mode of the stage.
void set_mode(controller::Shape& shape, double resonance_Hz) {
  if (auto* triangle = std::get_if<controller::Triangle>(&shape))
    triangle->mode_period_s = 1.0 / resonance_Hz;
  if (auto* raster = std::get_if<controller::Raster>(&shape)) raster->mode_period_s = 1.0 / resonance_Hz;
}

/// Where a table leaves out what the dynamics of its model file say, it is taken from there. The file is read
/// for keys that are left out alone.
class LeftOut {
 public:
  LeftOut(const Document& document, std::string table, std::optional<std::filesystem::path> model)
      : document_(document), table_(std::move(table)), model_(std::move(model)) {}

  void set_mode(double& resonance_Hz, double& damping_ratio) const {
    if (const auto dynamics = dynamics_for("resonance_Hz"))
      resonance_Hz = dynamics->mode.natural_frequency_Hz;
    if (const auto dynamics = dynamics_for("damping_ratio")) damping_ratio = dynamics->mode.damping_ratio;
  }
  /// The amplifier's lag is what the delay has more than the sensor's part of it.
  void set_amplifier(const char* key, double& bandwidth_Hz, double sensor_s) const {
    const auto dynamics = dynamics_for(key);
    if (!dynamics) return;
    const double lag_s = dynamics->delay_s - sensor_s;
    if (!(lag_s > 0.0))
      fail(key, fmt::format(": the model's delay of {:g} s is no more than the sensor's, {:g} s",
                            dynamics->delay_s, sensor_s));
    bandwidth_Hz = 1.0 / (2.0 * std::numbers::pi * lag_s);
  }

 private:
  /// None: the table has the key.
  std::optional<model::Dynamics> dynamics_for(const char* key) const {
    if (document_.root().at_path(table_ + "." + key)) return std::nullopt;
    const auto dynamics = model_ ? load_lag(*model_).dynamics : std::nullopt;
    if (!dynamics) fail(key, ", or [dynamics] in its model file");
    return dynamics;
  }
  [[noreturn]] void fail(const char* key, const std::string& more) const {
    document_.fail_at(table_, fmt::format("missing key {}, expected in [{}]{}", key, table_, more));
  }

  const Document& document_;
  std::string table_;
  std::optional<std::filesystem::path> model_;
};

/// The model file that the table names. None: a straight line stands for it.
using ModelFile = std::function<std::optional<std::filesystem::path>(
    const Document& document, const std::string& table, const std::filesystem::path& name)>;

std::optional<std::filesystem::path> measured(const Document& document, const std::string& table,
                                              const std::filesystem::path& name) {
  if (name.empty())
    document.fail_at(table,
                     fmt::format("missing key model, expected in [axis{}]", table.substr(table.rfind('.'))));
  return named_file(document, table + ".model", name);
}

std::optional<std::filesystem::path> measured_if_there(const Document& document, const std::string& table,
                                                       const std::filesystem::path& name) {
  if (name.empty() || !std::filesystem::exists(document.resolve(name))) return std::nullopt;
  return named_file(document, table + ".model", name);
}

model::HysteresisParameters line_through(const AxisConfig& axis) {
  const controller::Gate::Config& gate = axis.control.gate;
  const controller::Supervisor::Config& limits = axis.control.supervision;
  model::Interval positions{limits.position_min_um, limits.position_max_um};
  if (!std::isfinite(positions.span())) positions = {0.0, 1.0};
  const double margin = 0.1 * positions.span();  // to what ends a run
  positions = {positions.lo + margin, positions.hi - margin};
  return model::straight_line(axis.wire.drive_unit, "um", {gate.drive_min, gate.drive_max}, positions);
}

/// Loads the controller's model of axis i and sets what is derived from it.
void complete_control(const Document& document, Config& config, std::size_t i, const ModelFile& model_file) {
  AxisConfig& axis = config.axes[i];
  const auto file = model_file(document, fmt::format("axis[{}].control", i), axis.control_model);
  axis.control.law.model =
      file ? std::get<model::HysteresisParameters>(model::in_um(load_model(*file))) : line_through(axis);
  if (file) axis.control.law.creep = load_lag(*file).creep;
  controller::Delays& delays = axis.control.delays;
  const LeftOut left_out(document, fmt::format("axis[{}].control.delays", i), file);
  left_out.set_mode(delays.resonance_Hz, delays.damping_ratio);
  left_out.set_amplifier("amplifier_bandwidth_Hz", delays.amplifier_bandwidth_Hz, delays.sensor_s());
  open_transition_limits(document, config, i);
  derive(config, i);
}

/// Loads the setpoint files and the twin's model that axis i names.
void complete(const Document& document, AxisConfig& axis, std::size_t i, const ModelFile& model_file) {
  std::vector<controller::Segment>& segments = axis.control.setpoint;
  for (std::size_t j = 0; j < segments.size(); ++j)
    if (auto* table = std::get_if<controller::Table>(&segments[j].shape))
      table->curve = load_setpoint(
          named_file(document, fmt::format("axis[{}].control.setpoint[{}].file", i, j), table->file));
  const auto file = model_file(document, fmt::format("axis[{}].twin", i), axis.twin_model);
  twin::Plant::Config& plant = axis.twin.plant;
  plant.hysteresis = file ? model::in_um(load_any_parameters(*file)) : line_through(axis);
  if (file && !plant.creep) plant.hysteresis_creep = load_lag(*file).creep;
  const LeftOut left_out(document, fmt::format("axis[{}].twin", i), file);
  left_out.set_mode(plant.mode.natural_frequency_Hz, plant.mode.damping_ratio);
  left_out.set_amplifier("bandwidth_Hz", plant.amplifier.bandwidth_Hz,
                         std::chrono::duration<double>(axis.twin.sensor.delay).count());
}

/// Resolves the axes that the couplings of axis i name; `key` is their path ("axis[0].control.coupling").
void resolve_couplings(const Document& document, const Config& config, std::size_t i, const std::string& key,
                       std::vector<model::Coupling>& couplings) {
  for (std::size_t j = 0; j < couplings.size(); ++j) {
    const auto from = std::ranges::find(config.axes, couplings[j].from,
                                        [](const AxisConfig& axis) { return axis.wire.name; });
    if (from == config.axes.end() || from->wire.name == config.axes[i].wire.name)
      document.fail_at(fmt::format("{}[{}].from", key, j),
                       fmt::format("from is \"{}\", expected the name of another axis", couplings[j].from));
    couplings[j].index = static_cast<std::size_t>(from - config.axes.begin());
  }
}

/// A free-running sensor without a configured rate takes one sample per cycle by its own clock.
void set_sample_rate(const Config& config, node::SampleClock& clock) {
  if (clock.rate_Hz == 0.0) clock.rate_Hz = config.controller.rate_Hz;
}

/// Resolves the axes that the couplings of all axes name.
void resolve_couplings(const Document& document, Config& config) {
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    AxisConfig& axis = config.axes[i];
    resolve_couplings(document, config, i, fmt::format("axis[{}].control.coupling", i),
                      axis.control.couplings);
    resolve_couplings(document, config, i, fmt::format("axis[{}].twin.coupling", i), axis.twin.couplings);
  }
}

Config as_written(const Document& document) {
  Config config = read_config(document);
  for (std::size_t i = 0; i < config.axes.size(); ++i) complete_control(document, config, i, measured);
  return config;
}

Config load(const Document& document, const ModelFile& model_file) {
  Config config = read_config(document);
  if (config.bus.data_bitrate_bit_per_s == 0)
    for (can::Message& message : config.database.messages) message.bit_rate_switch = false;
  resolve_couplings(document, config);
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    AxisConfig& axis = config.axes[i];
    complete_control(document, config, i, model_file);
    complete(document, axis, i, model_file);
    set_sample_rate(config, axis.twin.sample_clock);
  }
  std::filesystem::path& black_boxes = config.controller.black_box.folder;
  if (!black_boxes.empty()) black_boxes = document.resolve(black_boxes);
  std::filesystem::path& states = config.controller.state_folder;
  if (!states.empty()) states = document.resolve(states);
  std::string& socket = config.controller.control_socket;
  if (!socket.empty() && socket != "none") socket = document.resolve(socket).string();
  check_agreement(document, config);
  for (std::size_t i = 0; i < config.axes.size(); ++i) plan_filters(document, config, i);
  return config;
}

}  // namespace

std::vector<std::string> axis_names(const Config& config) {
  std::vector<std::string> names;
  names.reserve(config.axes.size());
  for (const AxisConfig& axis : config.axes) names.push_back(axis.wire.name);
  return names;
}

controller::Config controller_config(const Config& config) {
  controller::Config derived{config.controller, {}, config.resting};
  derived.background_slots = config.bus.background_slots;
  derived.axes.reserve(config.axes.size());
  for (const AxisConfig& axis : config.axes)
    derived.axes.push_back({.wire = axis.wire,
                            .axis = axis.control,
                            .live_setpoint = axis.live_setpoint,
                            .scan_marker = axis.scan_marker});
  return derived;
}

twin::Config twin_config(const Config& config) {
  twin::Config derived{config.twin, {}};
  derived.cycle = controller::cycle_of(config.controller);
  derived.background_slots = config.bus.background_slots;
  derived.axes.reserve(config.axes.size());
  for (const AxisConfig& axis : config.axes) derived.axes.push_back({.wire = axis.wire, .axis = axis.twin});
  return derived;
}

void derive(Config& config, std::size_t i) {
  controller::AxisConfig& control = config.axes[i].control;
  const controller::ReferenceLimits usual =
      controller::default_transition_limits(control.gate, control.law.model, control.delays);
  controller::ReferenceLimits& limits = control.transition_limits;
  if (std::isfinite(limits.slew_um_per_s)) limits.slew_um_per_s = usual.slew_um_per_s;
  if (std::isfinite(limits.acceleration_um_per_s2))
    limits.acceleration_um_per_s2 = usual.acceleration_um_per_s2;
  for (controller::Segment& segment : control.setpoint) set_mode(segment.shape, control.delays.resonance_Hz);
}

Config load(const std::filesystem::path& file, const std::vector<Setting>& overrides) {
  return load(Document(file, overrides), measured);
}

Config load_text(const std::filesystem::path& file, std::string_view text) {
  return load(Document(file, text), measured);
}

Config load_unmeasured(const std::filesystem::path& file) { return load(Document(file), measured_if_there); }

Config load_as_written(const std::filesystem::path& file, const std::vector<Setting>& overrides) {
  return as_written(Document(file, overrides));
}

std::string echo(const std::filesystem::path& file, const std::vector<Setting>& overrides) {
  const Document document(file, overrides);
  Config config = as_written(document);
  Writer writer(Writer::Layout::plain, [&](const Setting& key, bool /*is_required*/) {
    const bool is_given = key.value.empty() || document.root().at_path(key.path);  // or a table
    return std::optional<std::string>(is_given ? "" : "default");
  });
  visit(writer, config);
  return writer.text();
}

}  // namespace hystcan::config
