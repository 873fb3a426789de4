#include "config/schema/config.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
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
#include "config/schema/settings.h"
#include "model/any_model.h"
#include "model/hysteresis_parameters.h"

namespace hystcan::config {
namespace {

model::HysteresisParameters line_through(const AxisConfig& axis) {
  const controller::Gate::Config& gate = axis.control.gate;
  const controller::Supervisor::Config& limits = axis.control.supervision;
  model::Interval positions{limits.position_min_um, limits.position_max_um};
  if (!std::isfinite(positions.span())) positions = {0.0, 1.0};
  // The straight line of drive and position replaces a missing model. The margin keeps both ends of this line
  // away from the position limits, at which an axis faults.
  const double margin = 0.1 * positions.span();
  positions = {positions.lo + margin, positions.hi - margin};
  return model::straight_line(axis.wire.drive_unit, "um", {gate.drive_min, gate.drive_max}, positions);
}

/// Builds a configuration from a TOML document and from the files that the document names.
class Loader {
 public:
  Loader(Document document, const ReadFiles& files, bool is_measured = true)
      : document_(std::move(document)), files_(files), is_measured_(is_measured) {}

  Config as_written() {
    read();
    for (AxisConfig& axis : config_.axes) complete_control(axis);
    return std::move(config_);
  }

  Config checked() {
    read();
    if (config_.bus.data_bitrate_bit_per_s == 0)
      for (can::Message& message : config_.database.messages) message.bit_rate_switch = false;
    for (AxisConfig& axis : config_.axes)
      for (auto* couplings : {&axis.control.couplings, &axis.twin.couplings})
        resolve(axis.wire.name, *couplings);
    for (AxisConfig& axis : config_.axes) {
      complete_control(axis);
      complete_twin(axis);
    }
    std::filesystem::path& black_boxes = config_.controller.black_box.folder;
    if (!black_boxes.empty()) black_boxes = document_.resolve(black_boxes);
    std::filesystem::path& states = config_.controller.state_folder;
    if (!states.empty()) states = document_.resolve(states);
    std::string& socket = config_.controller.control_socket;
    if (!socket.empty() && socket != "none") socket = document_.resolve(socket).string();
    check_agreement({document_, config_});
    for (std::size_t i = 0; i < config_.axes.size(); ++i) plan_filters(document_, config_, i);
    files_.drop_unused();
    return std::move(config_);
  }

 private:
  /// Reads the document into config_, and the messages of the DBC file that it names.
  void read() {
    config_.file = document_.file();
    Reader reader(document_, document_.root(), "");
    visit(reader, config_);
    reader.finish();
    config_.database = files_.get(file_named_by(config_.bus.dbc), can::load_dbc);
    for (AxisConfig& axis : config_.axes) {
      if (!axis.wire.frames) continue;
      choose_polynomial(axis, axis.wire.frames->command);
      if (axis.wire.frames->status) choose_polynomial(axis, *axis.wire.frames->status);
      choose_polynomial(axis, axis.wire.frames->sample);
    }
  }

  /// Returns the path of the file that the member `name` of config_ names. Throws Error with the place of its
  /// key if the file can't be read.
  std::filesystem::path file_named_by(const auto& name) const {
    std::filesystem::path file = document_.resolve(name);
    std::error_code ignored;
    const auto fail = [&](const std::string& what) {
      const std::string path = path_of(config_, name);
      document_.fail_at(path, fmt::format("{}: {}", path.substr(path.rfind('.') + 1), what));
    };
    const int error = ::access(file.c_str(), R_OK) == 0 ? 0 : errno;
    if (std::filesystem::is_directory(file, ignored))
      fail(fmt::format("{} is a folder, expected a file", file.string()));
    if (error == ENOENT) fail(fmt::format("no such file: {}", file.string()));
    if (error != 0)
      fail(fmt::format("{} cannot be read: {}", file.string(), std::generic_category().message(error)));
    return file;
  }

  /// Returns the path of the model file that the member `name` names. Returns nullopt for a stage that is not
  /// measured yet and whose file is missing: a straight line then replaces the model.
  std::optional<std::filesystem::path> model_named_by(const std::filesystem::path& name) const {
    if (!is_measured_ && (name.empty() || !std::filesystem::exists(document_.resolve(name))))
      return std::nullopt;
    if (!name.empty()) return file_named_by(name);
    const std::string path = path_of(config_, name), table = path.substr(0, path.rfind('.'));
    document_.fail_at(table,
                      fmt::format("missing key model, expected in [axis{}]", table.substr(table.rfind('.'))));
  }

  /// Returns true if the file or an override sets the key of this member of the axis.
  bool is_given(const AxisConfig& axis, const Member& member) const {
    return document_.has(fmt::format("axis[{}].{}", &axis - config_.axes.data(), path_of(axis, member)));
  }

  /// Sets the CRC polynomial of a message with CRC if the file does not set it. The default depends on the
  /// length of the message.
  void choose_polynomial(const AxisConfig& axis, can::MessageMap& map) const {
    const can::Message* message = config_.database.find(map.message);
    if (message != nullptr && map.integrity == can::Integrity::counter_crc && !is_given(axis, map.polynomial))
      map.polynomial = can::usual_crc(message->length);
  }

  /// Sets the index of the coupled axis in each coupling of the axis `name`. Throws Error if the coupling
  /// does not name another axis.
  void resolve(const std::string& name, std::vector<model::Coupling>& couplings) const {
    for (model::Coupling& coupling : couplings) {
      const auto from = std::ranges::find(config_.axes, coupling.from,
                                          [](const AxisConfig& axis) { return axis.wire.name; });
      if (from == config_.axes.end() || from->wire.name == name)
        document_.fail_at(path_of(config_, coupling.from),
                          fmt::format("from is \"{}\", expected the name of another axis", coupling.from));
      coupling.index = static_cast<std::size_t>(from - config_.axes.begin());
    }
  }

  /// Loads the controller's model of the axis and sets the values that are derived from the model.
  void complete_control(AxisConfig& axis) {
    const auto file = model_named_by(axis.control_model);
    axis.control.law.model =
        file ? std::get<model::HysteresisParameters>(model::in_um(files_.get(*file, load_model)))
             : line_through(axis);
    if (file) axis.control.law.creep = files_.get(*file, load_lag).creep;
    controller::Delays& delays = axis.control.delays;
    set_mode(axis, file, delays.resonance_Hz, delays.damping_ratio);
    set_amplifier(axis, file, delays.amplifier_bandwidth_Hz, delays.sensor_s());
    // A missing key slew_um_per_s or acceleration_um_per_s2 means no limit for the segments. The transitions
    // between segments still need a limit: it is set to 0 here, and derive() replaces the 0 by a default.
    const controller::ReferenceLimits& limits = axis.control.reference_limits;
    controller::ReferenceLimits& of_transitions = axis.control.transition_limits;
    if (!is_given(axis, limits.slew_um_per_s)) of_transitions.slew_um_per_s = 0.0;
    if (!is_given(axis, limits.acceleration_um_per_s2)) of_transitions.acceleration_um_per_s2 = 0.0;
    derive(config_, static_cast<std::size_t>(&axis - config_.axes.data()));
  }

  /// Loads the setpoint files of the axis and the model of its twin.
  void complete_twin(AxisConfig& axis) {
    for (controller::Segment& segment : axis.control.setpoint)
      if (auto* table = std::get_if<controller::Table>(&segment.shape))
        table->curve = files_.get(file_named_by(table->file), load_setpoint);
    const auto file = model_named_by(axis.twin_model);
    twin::Plant::Config& plant = axis.twin.plant;
    plant.hysteresis = file ? model::in_um(files_.get(*file, load_any_parameters)) : line_through(axis);
    if (file && !plant.creep) plant.hysteresis_creep = files_.get(*file, load_lag).creep;
    set_mode(axis, file, plant.mode.natural_frequency_Hz, plant.mode.damping_ratio);
    set_amplifier(axis, file, plant.amplifier.bandwidth_Hz,
                  std::chrono::duration<double>(axis.twin.sensor.delay).count());
    // A sensor with a clock of its own takes one sample per cycle, if the file does not set sample_rate_Hz.
    if (double& rate_Hz = axis.twin.sample_clock.rate_Hz; rate_Hz == 0.0)
      rate_Hz = config_.controller.rate_Hz;
  }

  // The functions below set the values of missing keys from [dynamics] in the model file of the axis. The
  // model file is only read if a key is missing.
  using File = std::optional<std::filesystem::path>;

  void set_mode(const AxisConfig& axis, const File& model, double& resonance_Hz,
                double& damping_ratio) const {
    if (const auto dynamics = dynamics_for(axis, model, resonance_Hz))
      resonance_Hz = dynamics->mode.natural_frequency_Hz;
    if (const auto dynamics = dynamics_for(axis, model, damping_ratio))
      damping_ratio = dynamics->mode.damping_ratio;
  }
  /// Sets the bandwidth of the amplifier if its key is missing. The lag of the amplifier is then the delay in
  /// the model file minus the delay of the sensor, `sensor_s`.
  void set_amplifier(const AxisConfig& axis, const File& model, double& bandwidth_Hz, double sensor_s) const {
    const auto dynamics = dynamics_for(axis, model, bandwidth_Hz);
    if (!dynamics) return;
    const double lag_s = dynamics->delay_s - sensor_s;
    if (!(lag_s > 0.0))
      fail_without(
          bandwidth_Hz,
          fmt::format(
              ": without this key, the model's delay ({:g} s) must exceed the sensor's delay ({:g} s)",
              dynamics->delay_s, sensor_s));
    bandwidth_Hz = 1.0 / (2.0 * std::numbers::pi * lag_s);
  }
  /// Returns [dynamics] of the model file if the configuration does not set `value`; nullopt if it sets
  /// `value`. Throws Error if the configuration does not set `value` and the model file has no [dynamics].
  std::optional<model::Dynamics> dynamics_for(const AxisConfig& axis, const File& model,
                                              const double& value) const {
    if (is_given(axis, value)) return std::nullopt;
    const auto dynamics = model ? files_.get(*model, load_lag).dynamics : std::nullopt;
    if (!dynamics) fail_without(value, ", or [dynamics] in the axis's model file");
    return dynamics;
  }
  [[noreturn]] void fail_without(const double& value, const std::string& more) const {
    const std::string path = path_of(config_, value), table = path.substr(0, path.rfind('.'));
    document_.fail_at(
        table, fmt::format("missing key {}, expected in [{}]{}", path.substr(table.size() + 1), table, more));
  }

  Document document_;
  const ReadFiles& files_;
  bool is_measured_;
  Config config_;
};

node::PositionRange positions_of(const controller::AxisConfig& control) {
  const controller::Supervisor::Config& limits = control.supervision;
  const model::Interval stroke = controller::model_reach_um(control.law.model, control.gate);
  node::Span setpoint{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const controller::Segment& segment : control.setpoint) {
    const controller::MotionBounds bounds = controller::motion_bounds(controller::prepared(segment.shape));
    setpoint = {std::min(setpoint.lo, bounds.lowest_um), std::max(setpoint.hi, bounds.highest_um)};
  }
  return {{limits.position_min_um, limits.position_max_um}, {stroke.lo, stroke.hi}, setpoint};
}

Document read_document(const std::filesystem::path& file) { return Document(file); }

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

std::vector<node::WiredAnalogueAxis> analogue_axes(const Config& config) {
  std::vector<node::WiredAnalogueAxis> axes;
  for (const AxisConfig& axis : config.axes) {
    const controller::Gate::Config& gate = axis.control.gate;
    if (axis.analogue)
      axes.push_back({axis.wire,
                      *axis.analogue,
                      {gate.drive_min, gate.drive_max, gate.safe_drive},
                      positions_of(axis.control)});
  }
  return axes;
}

void derive(Config& config, std::size_t i) {
  controller::AxisConfig& control = config.axes[i].control;
  const controller::ReferenceLimits usual =
      controller::default_transition_limits(control.gate, control.law.model, control.delays);
  controller::ReferenceLimits& limits = control.transition_limits;
  if (std::isfinite(limits.slew_um_per_s)) limits.slew_um_per_s = usual.slew_um_per_s;
  if (std::isfinite(limits.acceleration_um_per_s2))
    limits.acceleration_um_per_s2 = usual.acceleration_um_per_s2;
  const double mode_period_s = 1.0 / control.delays.resonance_Hz;
  // Sets the period of the mechanical mode in each segment with turnarounds: the turnarounds must not excite
  // the mode.
  for (controller::Segment& segment : control.setpoint) {
    if (auto* triangle = std::get_if<controller::Triangle>(&segment.shape))
      triangle->mode_period_s = mode_period_s;
    if (auto* raster = std::get_if<controller::Raster>(&segment.shape)) raster->mode_period_s = mode_period_s;
  }
}

Config load(const std::filesystem::path& file, const std::vector<Setting>& overrides,
            const ReadFiles& files) {
  return Loader(files.get(file, read_document).with(overrides), files).checked();
}

Config load_text(const std::filesystem::path& file, std::string_view text) {
  return Loader(Document(file, text), {}).checked();
}

Config load_unmeasured(const std::filesystem::path& file) {
  return Loader(Document(file), {}, false).checked();
}

Config load_as_written(const std::filesystem::path& file, const std::vector<Setting>& overrides,
                       const ReadFiles& files) {
  return Loader(files.get(file, read_document).with(overrides), files).as_written();
}

std::string echo(const std::filesystem::path& file, const std::vector<Setting>& overrides) {
  const Document document = Document(file).with(overrides);
  Config config = Loader(document, {}).as_written();
  Writer writer(Writer::Layout::plain, [&](const Setting& key, bool /*is_required*/) {
    const bool is_given = key.value.empty() || document.has(key.path);  // a table has an empty value
    return std::optional<std::string>(is_given ? "" : "default");
  });
  visit(writer, config);
  return writer.text();
}

}  // namespace hystcan::config
