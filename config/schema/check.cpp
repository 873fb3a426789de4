#include "config/schema/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "can/bus.h"
#include "config/files/csv.h"
#include "config/schema/bus_plan.h"
#include "config/schema/frames.h"
#include "controller/reference/shape.h"

namespace hystcan::config {
namespace {

/// Checks the keys of one axis.
class AxisCheck : Checked {
 public:
  AxisCheck(const Checked& checked, std::size_t index)
      : Checked(checked), index_(index), axis_(config.axes[index]), unit_(axis_.wire.drive_unit) {}

  void run() const {
    check_frames(*this, index_);
    check_model(axis_.control_model, axis_.control.law.model);
    check_model(axis_.twin_model, axis_.twin.plant.hysteresis);
    check_drive_range(axis_.control.gate, axis_.control.law.model.input_range());
    check_drive_range(axis_.twin.plant.amplifier, model::input_range(axis_.twin.plant.hysteresis));
    check_slow_physics();
    check_setpoint();
    check_filters();
    check_loop(*this, index_);
    check_watchdog();
    check_setup(axis_.wire.amplifier_setup);
    check_setup(axis_.wire.sensor_setup);
    check_setup_timeout();
    check_status_timeout();
  }

 private:
  void check_setup(const std::vector<can::SdoWrite>& writes) const {
    for (const can::SdoWrite& write : writes) {
      const auto& [value, bytes] = write.content;
      const std::uint64_t largest = (std::uint64_t{1} << 8U * bytes) - 1;
      if (value > largest) fail(value, "value is {}, expected at most {} in {} bytes", value, largest, bytes);
    }
  }

  void check_status_timeout() const {
    const double timeout_ms = 1e3 * can::seconds(axis_.control.supervision.status_timeout);
    const double period_ms = 1e3 * can::seconds(longest_status_period(config, axis_));
    if (timeout_ms == 0.0 || timeout_ms >= 2.0 * period_ms) return;
    if (axis_.analogue && axis_.analogue->amplifier.status_every > axis_.twin.status_every)
      fail(axis_.analogue->amplifier.status_every,
           "status_every is {}: two periods take {:g} ms, expected at most {:g}, status_timeout_ms of "
           "[axis.control]",
           axis_.analogue->amplifier.status_every, 2.0 * period_ms, timeout_ms);
    fail(axis_.control.supervision.status_timeout,
         "status_timeout_ms is {:g}, expected at least two periods of status_every, {:g}, or 0", timeout_ms,
         2.0 * period_ms);
  }

  /// Checks that setup_timeout_ms is at least one cycle, because the controller sends one setup request per
  /// cycle and must wait for the answer.
  void check_setup_timeout() const {
    if (axis_.wire.amplifier_setup.empty() && axis_.wire.sensor_setup.empty()) return;
    const double timeout_ms = 1e3 * can::seconds(axis_.wire.setup_patience.timeout);
    const double cycle_ms = 1e3 / config.controller.rate_Hz;
    if (timeout_ms < cycle_ms)
      fail(axis_.wire.setup_patience.timeout, "setup_timeout_ms is {:g}, expected at least one cycle, {:g}",
           timeout_ms, cycle_ms);
  }

  void check_model(const std::filesystem::path& file, const model::AnyParameters& model) const {
    if (input_unit(model) != unit_)
      fail(file, "the model's input_unit is \"{}\", expected \"{}\", the drive_unit of the axis",
           input_unit(model), unit_);
    if (output_unit(model) != "um")
      fail(file, "the model's output_unit is \"{}\", expected a length: um, nm, mm or m", output_unit(model));
  }

  void check_drive_range(const auto& drive, const model::Interval& thresholds) const {
    const double &min = drive.drive_min, &max = drive.drive_max, &safe = drive.safe_drive;
    if (!(min < max)) fail(max, "drive_max is {}, expected more than drive_min, {}", max, min);
    if (safe < min || safe > max) fail(safe, "safe_drive is {}, expected {} to {}", safe, min, max);
    if (max < thresholds.hi)
      fail(max,
           "drive_max is {}, expected at least {}: the drive must reach input_max, the upper "
           "threshold of the model",
           max, thresholds.hi);
  }

  void check_slow_physics() const {
    if (const auto& creep = axis_.twin.plant.creep; creep && creep->to_s <= creep->from_s)
      fail(creep->to_s, "to_s is {}, expected more than from_s, {}", creep->to_s, creep->from_s);
    if (const auto& t = axis_.twin.plant.temperature; t && std::abs(t->swing_K * t->gain_per_K) >= 1.0)
      fail(t->gain_per_K, "gain_per_K is {}, expected a magnitude of less than 1 / swing_K, {:g}",
           t->gain_per_K, 1.0 / t->swing_K);
  }

  void check_setpoint() const {
    const controller::AxisConfig& control = axis_.control;
    if (!(control.supervision.position_min_um < control.supervision.position_max_um))
      fail(control.supervision.position_max_um,
           "position_max_um is {}, expected more than position_min_um, {}",
           control.supervision.position_max_um, control.supervision.position_min_um);
    check_command_delay();
    for (const controller::Segment& segment : control.setpoint) check_segment(segment);
    check_in_position();
  }

  /// Checks command_delay_us if setpoints take effect at the SYNC: it must be one cycle. If setpoints take
  /// effect on receipt, check_receipt_delays() checks the key.
  void check_command_delay() const {
    if (axis_.twin.apply != node::Apply::sync) return;
    const can::Duration& delay = axis_.control.delays.command_delay;
    const std::int64_t cycle_us = std::llround(1e6 / config.controller.rate_Hz);
    if (std::chrono::abs(delay - std::chrono::microseconds(cycle_us)) > std::chrono::nanoseconds(500))
      fail(delay, "command_delay_us is {}, expected {}, one cycle: a setpoint takes effect at the next SYNC",
           static_cast<double>(delay.count()) * 1e-3, cycle_us);
  }

  void check_segment(const controller::Segment& segment) const {
    const controller::AxisConfig& control = axis_.control;
    const controller::MotionBounds bounds = motion_bounds_of(segment);
    for (const double value : {bounds.lowest_um, bounds.highest_um})
      if (value < control.supervision.position_min_um || value > control.supervision.position_max_um)
        fail(segment, "the setpoint reaches {} um, expected {} to {} um", value,
             control.supervision.position_min_um, control.supervision.position_max_um);
    const auto [slew_limit, acceleration_limit] = control.reference_limits;
    if (bounds.peak_slew_um_per_s > slew_limit * rounding)
      fail(segment, "the {} moves at up to {:.6g} um/s, expected at most {:g}, reference_slew_um_per_s",
           to_string(segment.shape), bounds.peak_slew_um_per_s, slew_limit);
    if (bounds.peak_acceleration_um_per_s2 > acceleration_limit * rounding)
      fail(segment,
           "the {} accelerates at up to {:.6g} um/s^2, expected at most {:g}, "
           "reference_acceleration_um_per_s2",
           to_string(segment.shape), bounds.peak_acceleration_um_per_s2, acceleration_limit);
  }

  controller::MotionBounds motion_bounds_of(const controller::Segment& segment) const {
    try {
      return controller::motion_bounds(controller::prepared(segment.shape));
    } catch (const std::invalid_argument& error) {
      throw Error(place_of(segment), error);
    }
  }

  /// Checks that timeout_ms of in_position is at least window_ms. Otherwise no move could arrive in time.
  void check_in_position() const {
    if (!axis_.control.in_position) return;
    const auto& [tolerance_um, window, timeout] = *axis_.control.in_position;
    if (timeout < window)
      fail(timeout, "timeout_ms is {:g}, expected at least window_ms, {:g}", 1e3 * can::seconds(timeout),
           1e3 * can::seconds(window));
  }

  void check_watchdog() const {
    if (axis_.control.verify_watchdog && !reports_state(axis_.wire))
      fail(axis_.control.verify_watchdog,
           "verify_watchdog is true, but the amplifier does not report its state, expected a status message "
           "with a signal for the role state");
  }

  void check_filters() const {
    const controller::ControlLaw::Config& law = axis_.control.law;
    const double highest_Hz = 0.5 * config.controller.rate_Hz;
    if (law.notch && !(law.notch->frequency_Hz < highest_Hz))
      fail(law.notch->frequency_Hz, "frequency_Hz is {}, expected less than half of rate_Hz, {}",
           law.notch->frequency_Hz, highest_Hz);
    if (axis_.control.delays.second_order && axis_.control.delays.plant_inverse)
      fail(axis_.control.delays.plant_inverse,
           "plant_inverse and second_order are both true, expected only one of them: both "
           "compensate the same delays");
  }

  static constexpr double rounding = 1.0 + 1e-9;  ///< factor on limits, which allows rounding errors
  std::size_t index_;
  const AxisConfig& axis_;
  const std::string& unit_;
};

void check_nodes(const Checked& checked) {
  const Config& config = checked.config;
  std::map<unsigned, const std::uint8_t*> taken{{config.controller.node, &config.controller.node}};
  const auto take = [&](const std::uint8_t& node) {
    const auto [before, is_new] = taken.emplace(node, &node);
    if (is_new) return;
    const std::string path = path_of(config, node), other = path_of(config, *before->second);
    checked.document.fail_at(
        path, fmt::format("node {} is used by {}, expected an unused node id{}", node, other,
                          other.substr(other.find('.')) == path.substr(path.find('.'))
                              ? ", or, if it is one node, one message for both axes in [axis.frames]"
                              : ""));
  };
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    if (first_sharing<can::AmpCommand>(config, i) == i) take(config.axes[i].wire.amplifier_node);
    if (first_sharing<can::SensorSample>(config, i) == i) take(config.axes[i].wire.sensor_node);
  }
}

void check_names(const Checked& checked) {
  std::set<std::string> taken;
  for (const AxisConfig& axis : checked.config.axes) {
    const std::string& name = axis.wire.name;
    if (!is_axis_name(name))
      checked.fail(name, "name is \"{}\", expected {}", in_one_line(shortened(name)), expected_axis_name);
    if (!taken.insert(name).second)
      checked.fail(name, "the name {} is used by another axis, expected a unique name", name);
  }
}

void check_cpus(const Checked& checked) {
  const Config& config = checked.config;
  if (!config.controller.realtime) return;
  const std::vector<std::int64_t>& cpus = config.controller.realtime->cpus;
  for (std::size_t i = 0; i < cpus.size(); ++i)
    if (const std::int64_t cpu = cpus[i]; cpu < 0 || cpu >= controller::Realtime::cpus_max)
      checked.document.fail_at(
          fmt::format("{}[{}]", path_of(config, cpus), i),
          fmt::format("processor {}, expected 0 to {}", cpu, controller::Realtime::cpus_max - 1));
}

void check_interface(const Checked& checked) {
  const BusConfig& bus = checked.config.bus;
  if (!can::is_interface_name(bus.interface))
    checked.fail(bus.interface, "interface is \"{}\", expected {}", bus.interface,
                 can::expected_interface_name);
  if (bus.data_bitrate_bit_per_s != 0 && bus.data_bitrate_bit_per_s < bus.bitrate_bit_per_s)
    checked.fail(bus.data_bitrate_bit_per_s,
                 "data_bitrate_bit_per_s is {}, expected at least bitrate_bit_per_s, {}, or 0 for a "
                 "bus without bit-rate switch",
                 bus.data_bitrate_bit_per_s, bus.bitrate_bit_per_s);
}

void check_faults(const Checked& checked) {
  const Config& config = checked.config;
  for (const twin::FaultSpec& fault : config.twin.faults) {
    const auto axis = std::ranges::find(
        config.axes, fault.axis, [](const AxisConfig& one) -> const auto& { return one.wire.name; });
    if (axis == config.axes.end())
      checked.fail(fault.axis, "axis is \"{}\", expected the name of an axis", fault.axis);
    if (const auto why = reason_against(fault, axis->wire)) checked.fail(fault.kind, "{}", *why);
    if (fault.repeat_every > can::Duration::zero() && fault.repeat_every <= fault.lasts)
      checked.fail(fault.repeat_every, "repeat_every_s is {:g}, expected more than duration_s, {:g}",
                   can::seconds(fault.repeat_every), can::seconds(fault.lasts));
  }
  const auto& random = config.twin.random_faults;
  if (random && random->longest < random->shortest)
    checked.fail(random->longest, "duration_max_s is {:g}, expected at least duration_min_s, {:g}",
                 can::seconds(random->longest), can::seconds(random->shortest));
}

}  // namespace

bool is_axis_name(std::string_view name) {
  constexpr std::size_t longest = 64;
  const auto fits = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '.' || c == '-';
  };
  return !name.empty() && name.size() <= longest && name != "." && name != ".." &&
         std::ranges::all_of(name, fits);
}

void check_agreement(const Checked& checked) {
  const Config& config = checked.config;
  check_interface(checked);
  check_names(checked);
  check_cpus(checked);
  check_nodes(checked);
  if (config.controller.heartbeat_timeout < 2 * config.twin.heartbeat_period)
    checked.fail(config.controller.heartbeat_timeout,
                 "heartbeat_timeout_ms is shorter than two heartbeats of a node, expected at least twice the "
                 "heartbeat_ms of the nodes");
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    AxisCheck(checked, i).run();
    check_instruments(checked, i);
  }
  check_scans(checked);
  check_analogue(checked);
  check_faults(checked);
  check_sharing(checked);
  check_identifiers(checked);
  check_bus(checked);
  check_receipt_delays(checked);
}

}  // namespace hystcan::config
