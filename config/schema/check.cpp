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

/// The checks of one axis, at `path` ("axis[0]").
class AxisCheck {
 public:
  AxisCheck(const Document& document, const Config& config, std::size_t index)
      : document_(document),
        config_(config),
        index_(index),
        axis_(config.axes[index]),
        path_(fmt::format("axis[{}]", index)),
        unit_(axis_.wire.drive_unit) {}

  void run() const {
    check_frames(document_, config_, index_);
    check_model("control.model", axis_.control.law.model);
    check_model("twin.model", axis_.twin.plant.hysteresis);
    check_drive_range("control", axis_.control.gate.drive_min, axis_.control.gate.drive_max,
                      axis_.control.gate.safe_drive, axis_.control.law.model.input_range());
    const twin::Amplifier::Config& amplifier = axis_.twin.plant.amplifier;
    check_drive_range("twin", amplifier.drive_min, amplifier.drive_max, amplifier.safe_drive,
                      model::input_range(axis_.twin.plant.hysteresis));
    check_slow_physics();
    check_setpoint();
    check_filters();
    check_loop(document_, config_, index_);
    check_watchdog();
    check_setup("amplifier_setup", axis_.wire.amplifier_setup);
    check_setup("sensor_setup", axis_.wire.sensor_setup);
    check_setup_timeout();
    check_status_timeout();
  }

 private:
  template <class... Args>
  [[noreturn]] void fail(const std::string& key, fmt::format_string<Args...> format, Args&&... args) const {
    document_.fail_at(path_ + "." + key, fmt::format(format, std::forward<Args>(args)...));
  }

  void check_setup(const char* list, const std::vector<can::SdoWrite>& writes) const {
    for (std::size_t i = 0; i < writes.size(); ++i) {
      const auto [value, bytes] = writes[i].content;
      const std::uint64_t largest = (std::uint64_t{1} << 8U * bytes) - 1;
      if (value > largest)
        fail(fmt::format("{}[{}].value", list, i), "value is {}, expected at most {} in {} bytes", value,
             largest, bytes);
    }
  }

  void check_status_timeout() const {
    const double timeout_ms = 1e3 * can::seconds(axis_.control.supervision.status_timeout);
    const double period_ms = 1e3 * can::seconds(longest_status_period(config_, axis_));
    if (timeout_ms > 0.0 && timeout_ms < 2.0 * period_ms)
      fail("control.status_timeout_ms",
           "status_timeout_ms is {:g}, expected at least two periods of status_every, {:g}, or 0", timeout_ms,
           2.0 * period_ms);
  }

  /// The controller sends one request per cycle, so it must wait at least one cycle for the answer.
  void check_setup_timeout() const {
    if (axis_.wire.amplifier_setup.empty() && axis_.wire.sensor_setup.empty()) return;
    const double timeout_ms = 1e3 * can::seconds(axis_.wire.setup_patience.timeout);
    const double cycle_ms = 1e3 / config_.controller.rate_Hz;
    if (timeout_ms < cycle_ms)
      fail("setup_timeout_ms", "setup_timeout_ms is {:g}, expected at least one cycle, {:g}", timeout_ms,
           cycle_ms);
  }

  void check_model(const char* key, const model::AnyParameters& model) const {
    if (input_unit(model) != unit_)
      fail(key, "the model's input_unit is \"{}\", expected \"{}\" as drive_unit", input_unit(model), unit_);
    if (output_unit(model) != "um")
      fail(key, "the model's output_unit is \"{}\", expected a length: um, nm, mm or m", output_unit(model));
  }

  void check_drive_range(const std::string& section, double min, double max, double safe,
                         const model::Interval& thresholds) const {
    const auto key = [&](const char* what) { return fmt::format("{}.{}_{}", section, what, unit_); };
    if (!(min < max)) fail(key("drive_max"), "drive_max is {}, expected more than drive_min, {}", max, min);
    if (safe < min || safe > max)
      fail(key("safe_drive"), "safe_drive is {}, expected within {} and {}", safe, min, max);
    if (max < thresholds.hi)
      fail(key("drive_max"),
           "drive_max is {}, expected at least {}: the model's upper threshold must be reached", max,
           thresholds.hi);
  }

  void check_slow_physics() const {
    if (const auto& creep = axis_.twin.plant.creep; creep && creep->to_s <= creep->from_s)
      fail("twin.creep.to_s", "to_s is {}, expected more than from_s, {}", creep->to_s, creep->from_s);
    if (const auto& t = axis_.twin.plant.temperature; t && std::abs(t->swing_K * t->gain_per_K) >= 1.0)
      fail("twin.temperature.gain_per_K", "gain_per_K is {}, expected less than 1 / swing_K, {:g}",
           t->gain_per_K, 1.0 / t->swing_K);
  }

  void check_setpoint() const {
    const controller::AxisConfig& control = axis_.control;
    if (!(control.supervision.position_min_um < control.supervision.position_max_um))
      fail("control.position_max_um", "position_max_um is {}, expected more than position_min_um, {}",
           control.supervision.position_max_um, control.supervision.position_min_um);
    check_command_delay();
    for (std::size_t i = 0; i < control.setpoint.size(); ++i)
      check_segment(fmt::format("control.setpoint[{}]", i), control.setpoint[i].shape);
    check_in_position();
  }

  /// For setpoints that take effect on receipt, check_receipt_delays() checks the delay.
  void check_command_delay() const {
    if (axis_.twin.apply != node::Apply::sync) return;
    const can::Duration delay = axis_.control.delays.command_delay;
    const std::int64_t cycle_us = std::llround(1e6 / config_.controller.rate_Hz);
    if (std::chrono::abs(delay - std::chrono::microseconds(cycle_us)) > std::chrono::nanoseconds(500))
      fail("control.delays.command_delay_us",
           "command_delay_us is {}, expected {}, one cycle: a setpoint takes effect at the next SYNC",
           static_cast<double>(delay.count()) * 1e-3, cycle_us);
  }

  void check_segment(const std::string& key, const controller::Shape& shape) const {
    const controller::AxisConfig& control = axis_.control;
    const controller::MotionBounds bounds = motion_bounds_of(key, shape);
    for (const double value : {bounds.lowest_um, bounds.highest_um})
      if (value < control.supervision.position_min_um || value > control.supervision.position_max_um)
        fail(key, "the setpoint goes to {} um, expected within {} and {} um", value,
             control.supervision.position_min_um, control.supervision.position_max_um);
    const auto [slew_limit, acceleration_limit] = control.reference_limits;
    if (bounds.peak_slew_um_per_s > slew_limit * rounding)
      fail(key, "the {} moves at up to {:.6g} um/s, expected at most {:g}, reference_slew_um_per_s",
           to_string(shape), bounds.peak_slew_um_per_s, slew_limit);
    if (bounds.peak_acceleration_um_per_s2 > acceleration_limit * rounding)
      fail(key,
           "the {} accelerates at up to {:.6g} um/s^2, expected at most {:g}, "
           "reference_acceleration_um_per_s2",
           to_string(shape), bounds.peak_acceleration_um_per_s2, acceleration_limit);
  }

  controller::MotionBounds motion_bounds_of(const std::string& key, const controller::Shape& shape) const {
    try {
      return controller::motion_bounds(controller::prepared(shape));
    } catch (const std::invalid_argument& error) {
      fail(key, "{}", error.what());
    }
  }

  /// With timeout < window, every move would fail.
  void check_in_position() const {
    if (!axis_.control.in_position) return;
    const auto& [tolerance_um, window, timeout] = *axis_.control.in_position;
    if (timeout < window)
      fail("control.in_position.timeout_ms", "timeout_ms is {:g}, expected at least window_ms, {:g}",
           1e3 * can::seconds(timeout), 1e3 * can::seconds(window));
  }

  void check_watchdog() const {
    if (axis_.control.verify_watchdog && !reports_state(axis_.wire))
      fail("control.verify_watchdog",
           "the amplifier does not report its state, expected a status with the role state");
  }

  void check_filters() const {
    const controller::ControlLaw::Config& law = axis_.control.law;
    const double highest_Hz = 0.5 * config_.controller.rate_Hz;
    if (law.notch && !(law.notch->frequency_Hz < highest_Hz))
      fail("control.notch.frequency_Hz", "frequency_Hz is {}, expected less than half of rate_Hz, {}",
           law.notch->frequency_Hz, highest_Hz);
    if (axis_.control.delays.second_order && axis_.control.delays.plant_inverse)
      fail("control.delays.plant_inverse",
           "plant_inverse and second_order are both true, expected one of them: each is a feed-forward");
  }

  static constexpr double rounding = 1.0 + 1e-9;  ///< tolerates a shape that is exactly at its limit
  const Document& document_;
  const Config& config_;
  std::size_t index_;
  const AxisConfig& axis_;
  std::string path_;
  std::string unit_;
};

void check_nodes(const Document& document, const Config& config) {
  std::map<unsigned, std::string> taken{{config.controller.node, "controller.node"}};
  const auto take = [&](unsigned node, const std::string& path) {
    if (const auto [before, is_new] = taken.emplace(node, path); !is_new)
      document.fail_at(
          path, fmt::format("node {} is taken by {}, expected a node id of its own{}", node, before->second,
                            before->second.substr(before->second.find('.')) == path.substr(path.find('.'))
                                ? ", or the same message in [axis.frames]"
                                : ""));
  };
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    if (first_sharing<can::AmpCommand>(config, i) == i)
      take(config.axes[i].wire.amplifier_node, fmt::format("axis[{}].amplifier_node", i));
    if (first_sharing<can::SensorSample>(config, i) == i)
      take(config.axes[i].wire.sensor_node, fmt::format("axis[{}].sensor_node", i));
  }
}

void check_names(const Document& document, const Config& config) {
  std::set<std::string> taken;
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    const std::string& name = config.axes[i].wire.name;
    const std::string path = fmt::format("axis[{}].name", i);
    if (!is_axis_name(name))
      document.fail_at(
          path, fmt::format("name is \"{}\", expected {}", in_one_line(shortened(name)), expected_axis_name));
    if (!taken.insert(name).second)
      document.fail_at(path, fmt::format("the name {} is taken, expected one of its own", name));
  }
}

void check_cpus(const Document& document, const controller::CommonConfig& controller) {
  if (!controller.realtime) return;
  for (std::size_t i = 0; i < controller.realtime->cpus.size(); ++i)
    if (const std::int64_t cpu = controller.realtime->cpus[i];
        cpu < 0 || cpu >= controller::Realtime::cpus_max)
      document.fail_at(
          fmt::format("controller.realtime.cpus[{}]", i),
          fmt::format("processor {}, expected 0 to {}", cpu, controller::Realtime::cpus_max - 1));
}

void check_interface_name(const Document& document, const std::string& name) {
  if (!can::is_interface_name(name))
    document.fail_at("bus.interface",
                     fmt::format("interface is \"{}\", expected {}", name, can::expected_interface_name));
}

void check_bit_rates(const Document& document, const BusConfig& bus) {
  if (bus.data_bitrate_bit_per_s == 0 || bus.data_bitrate_bit_per_s >= bus.bitrate_bit_per_s) return;
  document.fail_at(
      "bus.data_bitrate_bit_per_s",
      fmt::format("data_bitrate_bit_per_s is {}, expected at least bitrate_bit_per_s, {}, or 0 for a "
                  "bus without bit-rate switch",
                  bus.data_bitrate_bit_per_s, bus.bitrate_bit_per_s));
}

void check_faults(const Document& document, const Config& config) {
  const std::vector<twin::FaultSpec>& faults = config.twin.faults;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const auto axis = std::ranges::find(
        config.axes, faults[i].axis, [](const AxisConfig& one) -> const auto& { return one.wire.name; });
    if (axis == config.axes.end())
      document.fail_at(fmt::format("twin.fault[{}].axis", i),
                       fmt::format("axis is \"{}\", expected the name of one", faults[i].axis));
    if (const auto why = reason_against(faults[i], axis->wire))
      document.fail_at(fmt::format("twin.fault[{}].kind", i), *why);
    if (faults[i].repeat_every > can::Duration::zero() && faults[i].repeat_every <= faults[i].lasts)
      document.fail_at(fmt::format("twin.fault[{}].repeat_every_s", i),
                       fmt::format("repeat_every_s is {:g}, expected more than duration_s, {:g}",
                                   can::seconds(faults[i].repeat_every), can::seconds(faults[i].lasts)));
  }
  const auto& random = config.twin.random_faults;
  if (random && random->longest < random->shortest)
    document.fail_at("twin.random_faults.duration_max_s",
                     fmt::format("duration_max_s is {:g}, expected at least duration_min_s, {:g}",
                                 can::seconds(random->longest), can::seconds(random->shortest)));
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

void check_agreement(const Document& document, const Config& config) {
  check_interface_name(document, config.bus.interface);
  check_bit_rates(document, config.bus);
  check_names(document, config);
  check_cpus(document, config.controller);
  check_nodes(document, config);
  if (config.controller.heartbeat_timeout < 2 * config.twin.heartbeat_period)
    document.fail_at("controller.heartbeat_timeout_ms",
                     "heartbeat_timeout_ms is shorter than two of the nodes' heartbeat_ms, expected at least "
                     "twice as long");
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    AxisCheck(document, config, i).run();
    check_instruments(document, config, i);
  }
  check_scans(document, config);
  check_faults(document, config);
  check_sharing(document, config);
  check_identifiers(document, config);
  check_bus(document, config);
  check_receipt_delays(document, config);
}

}  // namespace hystcan::config
