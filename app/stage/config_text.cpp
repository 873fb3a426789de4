#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>

#include "app/stage/dynamics_text.h"
#include "app/stage/first_stage.h"
#include "config/schema/config.h"
#include "config/schema/frames.h"
#include "config/schema/settings.h"

namespace hystcan::app {
namespace {

constexpr const char* heading =
    "# Written by `hystcan init`. "
    "Check the values marked `assumed`: they were neither stated nor measured.\n#\n"
    "#   hystcan check FILE         show the active values and their consequences\n"
    "#   hystcan {}\n"
    "#   hystcan controller FILE    control the stage, while the command above is running\n\n";

/// Builds the configuration of one axis from the known facts, and the comments after its keys.
class FirstAxis {
 public:
  FirstAxis(const AxisFacts& facts, double rate_Hz, std::string path,
            std::map<std::string, std::string>& remarks)
      : facts_(facts),
        rate_Hz_(rate_Hz),
        path_(std::move(path)),
        remarks_(remarks),
        axis_(facts.config),
        range_(axis_.control.gate.drive_max - axis_.control.gate.drive_min),
        slew_per_s_(range_ * std::min(0.4 * axis_.control.delays.resonance_Hz, 0.2 * rate_Hz)) {}

  config::AxisConfig make() {
    set_wire();
    set_loop();
    set_limits();
    set_delays();
    set_reference();
    set_twin();
    set_analogue();
    return axis_;
  }

 private:
  /// Sets the comment after a key. A key with a remark is always written, even if it is optional and has its
  /// default value; the comment may be empty.
  void remark(const config::Member& member, const std::string& comment = {}) {
    remarks_[path_ + path_of(axis_, member)] = comment;
  }

  void set_wire() {
    remark(axis_.wire.message_prefix,
           fmt::format("messages {0}AmpCommand, {0}AmpStatus, {0}SensorSample of the DBC",
                       axis_.wire.message_prefix));
    if (const auto& frames = axis_.wire.frames)
      for (const can::MessageMap* map :
           {&frames->command, frames->status ? &*frames->status : nullptr, &frames->sample})
        if (map != nullptr && map->integrity == can::Integrity::counter_crc)
          remark(map->polynomial, "assumed; the bytes that the CRC covers are also assumed");
  }

  void set_loop() {
    const double omega = 2.0 * std::numbers::pi * axis_.control.delays.resonance_Hz;
    axis_.control.law.structure = controller::Structure::inverse_pi;
    axis_.control.law.pi.ki_per_s =
        rounded(std::min(0.5 * axis_.control.delays.damping_ratio * omega, 0.1 * rate_Hz_), 3);
    axis_.control.repeat = true;
    axis_.control.in_position = {.tolerance_um = rounded(0.002 * facts_.travel_um.span(), 2),
                                 .window = std::chrono::milliseconds(20),
                                 .timeout = std::chrono::seconds(2)};
    remark(axis_.control.law.structure, "average, inverse, pi, average+pi, inverse+pi");
    remark(axis_.control.law.pi.kp, "um per um");
    remark(axis_.control.law.pi.ki_per_s,
           "1/s; `hystcan check` judges the loop, `hystcan tune` proposes other gains");
    if (config::reports_state(axis_.wire)) return;
    axis_.control.enable_delay = std::chrono::milliseconds(500);
    remark(axis_.control.enable_delay, "assumed: the frames do not report when the amplifier is on");
  }

  /// Sets the limits of drive, position and following error.
  void set_limits() {
    const double stroke = facts_.travel_um.span();
    controller::AxisConfig& control = axis_.control;
    control.gate.slew_per_s = rounded(slew_per_s_, 2);
    control.wipe_slew_per_s = rounded(std::min(5.0 * range_, slew_per_s_), 2);
    control.wipe_dwell_s = rounded(std::max(0.1, 20.0 / control.delays.resonance_Hz), 3);
    const model::Interval position = position_limits_um(facts_.travel_um);
    control.supervision.position_min_um = rounded(position.lo, 3);
    control.supervision.position_max_um = rounded(position.hi, 3);
    control.supervision.position_jump_um = rounded(0.15 * stroke, 2);
    control.supervision.missing_samples = 3;
    control.following_error.error_um = rounded(0.15 * stroke, 2);
    control.following_error.cycles = 3;
    remark(control.gate.drive_min, "the controller's drive stays between drive_min and drive_max");
    remark(control.gate.safe_drive, "the drive at the end of every run");
    remark(control.gate.slew_per_s, "assumed: full drive range in 2.5 periods of the resonance");
    remark(control.wipe_slew_per_s,
           "slew of the ramps; start-up moves to drive_max and back, which erases the stage's memory");
    remark(control.wipe_dwell_s);
    remark(control.supervision.position_min_um,
           "a position outside position_min_um to position_max_um ends the run");
    remark(control.supervision.position_jump_um,
           "maximum change per cycle; a larger jump means a loose cable");
    remark(control.following_error.error_um,
           "assumed; structure \"pi\" has larger errors and needs a larger limit");
    remark(control.supervision.missing_samples);
  }

  void set_delays() {
    const char* origin = facts_.mode_is_measured ? "from the step record" : "stated, not measured";
    controller::Delays& delays = axis_.control.delays;
    delays.command_delay = std::chrono::microseconds(std::llround(1e6 / rate_Hz_));
    delays.amplifier_bandwidth_Hz = rounded(std::max(1000.0, 3.0 * delays.resonance_Hz), 3);
    remark(delays.command_delay, "one cycle: the amplifier applies a setpoint at the next SYNC");
    remark(delays.amplifier_bandwidth_Hz, "assumed: no step was recorded");
    remark(delays.resonance_Hz, origin);
    remark(delays.damping_ratio, facts_.damping_is_assumed ? "assumed" : origin);
    if (delays.sensor_delay.count() > 0) remark(delays.sensor_delay, "stated, not measured");
  }

  void set_reference() {
    const auto at = [&](double share) {
      return rounded(facts_.travel_um.lo + share * facts_.travel_um.span(), 4);
    };
    // Makes the reference slower if the resonance is below 200 Hz or the cycle rate is below 500 Hz.
    const double slowness = std::max({1.0, 200.0 / axis_.control.delays.resonance_Hz, 500.0 / rate_Hz_});
    controller::Staircase stairs{
        .levels_um = {}, .rise_s = rounded(0.05 * slowness, 2), .dwell_s = rounded(0.1 * slowness, 2)};
    for (const double share : {0.9, 0.15, 0.8, 0.25, 0.7, 0.35, 0.6, 0.45, 0.5})
      stairs.levels_um.push_back(at(share));
    axis_.control.setpoint = {{.shape = controller::Triangle{.low_um = at(0.1),
                                                             .high_um = at(0.9),
                                                             .frequency_Hz = rounded(10.0 / slowness, 2),
                                                             .cycles = 10.0},
                               .transition_s = rounded(0.3 * slowness, 2)},
                              {.shape = stairs, .transition_s = rounded(0.2 * slowness, 2)}};
    remark(axis_.control.setpoint[0], "a triangle over 80 % of the travel");
    remark(axis_.control.setpoint[1],
           "many levels, each reversal smaller than the last: the memory keeps all of them");
  }

  void set_twin() {
    twin::AxisConfig& twin = axis_.twin;
    const controller::Gate::Config& gate = axis_.control.gate;
    const controller::Delays& delays = axis_.control.delays;
    twin.plant.mode.natural_frequency_Hz = delays.resonance_Hz;
    twin.plant.mode.damping_ratio = delays.damping_ratio;
    twin.plant.amplifier.drive_min = rounded(gate.drive_min - 0.2 * range_, 3);
    twin.plant.amplifier.drive_max = rounded(gate.drive_max + 0.2 * range_, 3);
    twin.plant.amplifier.safe_drive = gate.safe_drive;
    twin.plant.amplifier.slew_per_s = rounded(4.0 * slew_per_s_, 2);
    twin.plant.amplifier.bandwidth_Hz = delays.amplifier_bandwidth_Hz;
    twin.command_timeout =
        std::chrono::microseconds(std::llround(1e3 * rounded(std::max(20.0, 20e3 / rate_Hz_), 2)));
    twin.sensor.resolution_um = rounded(twin.sensor.noise_um_rms / 3.0, 1);
    twin.sensor.noise_um_rms = rounded(twin.sensor.noise_um_rms, 2);
    twin.sensor.delay = delays.sensor_delay;
    remark(twin.plant.amplifier.drive_min, "assumed: wider than the controller's drive range");
    remark(twin.plant.amplifier.slew_per_s, "assumed");
    remark(twin.plant.amplifier.bandwidth_Hz, "assumed");
    if (delays.sensor_delay.count() > 0) remark(twin.sensor.delay, "stated");
  }

  void set_analogue() {
    if (!axis_.analogue) return;
    remark(axis_.analogue->drive_output.channel,
           "assumed; the number of the input channel is assumed too; `hystcan doctor` examines the card");
    remark(axis_.analogue->volts_per_drive, "stated: the amplifier's gain");
    remark(axis_.analogue->position_um_per_V, "stated: the sensor");
    remark(axis_.analogue->position_zero_um, "assumed: position at which the output of the sensor is 0 V");
  }

  const AxisFacts& facts_;
  double rate_Hz_;
  std::string path_;
  std::map<std::string, std::string>& remarks_;
  config::AxisConfig axis_;
  double range_;       ///< width of the drive range
  double slew_per_s_;  ///< drive units per second; a ramp at this rate crosses the drive range in 2.5 periods
                       ///< of the mode, or in 5 cycles if that is longer
};

}  // namespace

model::Interval position_limits_um(const model::Interval& travel_um) {
  const double margin = 0.15 * travel_um.span();
  return {travel_um.lo - margin, travel_um.hi + margin};
}

std::string config_text(const StageFacts& facts) {
  config::Config config = facts.config;
  config.bus.dbc = config.bus.dbc.filename();
  config.twin.heartbeat_period = std::chrono::milliseconds(100);
  std::map<std::string, std::string> remarks{{path_of(config, config.twin.seed), ""}};
  for (std::size_t i = 0; i < facts.axes.size(); ++i)
    config.axes.push_back(
        FirstAxis(facts.axes[i], config.controller.rate_Hz, fmt::format("axis[{}].", i), remarks).make());
  const bool is_analogue = config.axes.front().analogue.has_value();
  return fmt::format(heading, is_analogue ? "node FILE          connect the analogue card to the bus"
                                          : "twin FILE          simulate the stage on the bus") +
         config::file_text(config, remarks);
}

}  // namespace hystcan::app
