// Decides in every cycle if a driven axis may stay driven. The decision is a pure step: it takes the received
// data and the decided command, and returns a verdict.
//
//   sample     the axis continues without a sample that is lost, late or jumped, but counts it; several such
//              samples in a row trip the axis
//   jump       |y - y_last| > position_jump_um for each cycle since y_last. y is the position in the sample,
//              y_last the last accepted position. After a jump, the next y is accepted if y - y_last
//              differs by no more than this limit from the motion of the model since y_last (course.h). So a
//              real motion of the stage is accepted
//   frozen     y is the same to the last bit for frozen_cycles, while the drive travels more than a fiftieth
//              of its range: noise and motion would change the reading of any real sensor
//   enable     the amplifier must report "enabled" within enable_timeout_s; after that, any other state is a
//              fault
//   saturated  range, slew or the model's thresholds limit the drive for saturated_s without interruption
//
// If several causes are present at once, the verdict is the cause that can have produced the others: bus-off,
// for example, and not the missing samples that follow from it.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "controller/control/fault.h"
#include "model/reference_curve.h"

namespace hystcan::controller {

/// State of the bus, of the sensor node and of the amplifier node of an axis, at the time of a step.
struct NodeHealth {
  bool interface_up = true;
  bool bus_on = true;          ///< the bus is not in the state bus-off
  bool bus_passive = false;    ///< our own CAN controller is error-passive
  bool commands_late = false;  ///< two commands have been queued but have not reached the wire
  bool sensor_alive = false;   ///< the sensor's last heartbeat was received in time
  bool sensor_operational = false;
  bool amplifier_alive = false;
  bool amplifier_operational = false;
  bool restarted = false;          ///< a node booted up since the last cycle
  bool emergency = false;          ///< a node sent an EMCY other than "no error" since the last cycle
  bool amplifier_ready = false;    ///< the amplifier's last status reported ready or enabled
  bool amplifier_enabled = false;  ///< the amplifier's last status reported enabled
  bool amplifier_fault = false;    ///< the amplifier's last status reported a fault
  double amplifier_output = 0.0;   ///< output in the amplifier's last status, drive units
  bool output_reported = false;    ///< the amplifier sends statuses with its output
  bool amplifier_moves = false;    ///< true until a status has shown the output at rest
  double status_age_s = 0.0;       ///< age of the last status; 0 if the amplifier sends none
};

/// True if the amplifier receives and follows commands, according to the last frames of its node and the
/// state of the bus.
bool obeys_commands(const NodeHealth& health);

/// True if the last status of the amplifier is older than `timeout`. False if `timeout` is 0.
bool is_status_too_old(const NodeHealth& health, std::chrono::nanoseconds timeout);

struct AxisInput {
  double time_s = 0.0;   ///< time of this cycle's SYNC, since the controller's start
  double dt_s = 0.0;     ///< time since the last cycle's SYNC
  double cycle_s = 0.0;  ///< nominal time of a cycle
  /// Total time by which late SYNCs have delayed the references of all axes since the controller's start
  /// (sync_clock.h).
  double waited_s = 0.0;
  std::optional<double> position_um;  ///< measured position; `nullopt`: no sample arrived
  bool sensor_status_good = true;
  bool late_sample = false;  ///< a sample of an earlier cycle arrived since the last step
  /// Value of reference_time_s() when the axes began to track. `nullopt`: this axis does not begin to track
  /// yet.
  std::optional<double> tracking_since_s{};
  double coupled_um = 0.0;  ///< displacement by the other axes (coupling) at the time when this command acts
  NodeHealth health;

  double reference_time_s() const { return time_s - waited_s; }
};

struct AxisCommand {
  double drive = 0.0;
  bool enable = false;
  bool clear_fault = false;
  bool withheld = false;  ///< true: the command is not sent, so that the amplifier's watchdog trips
};

class Supervisor {
 public:
  struct Config {
    /// Lower limit of plausible positions. A position below this limit shows that the sensor or the stage is
    /// broken.
    double position_min_um = 0.0;
    double position_max_um = 0.0;
    double position_jump_um = 0.0;  ///< maximum change of the position per cycle; 0: not judged
    /// Maximum number of consecutive lost samples; one more trips the axis.
    unsigned missing_samples = 3;
    unsigned frozen_cycles = 50;  ///< number of cycles with exactly the same position; 0: not judged
    double saturated_s = 2.0;     ///< maximum time at a limit of the drive; 0: not judged
    double bus_passive_s = 0.5;   ///< maximum time for which the bus is error-passive; 0: not judged
    /// Maximum age of the amplifier's last status; 0: not judged.
    std::chrono::nanoseconds status_timeout{std::chrono::seconds(1)};
    /// Maximum time from the first command with Enable until the amplifier reports "enabled".
    double enable_timeout_s = 0.5;
    double drive_range = 0.0;  ///< drive_max - drive_min, drive units
  };
  struct Verdict {
    Cause cause = Cause::none;
    std::optional<double> position_um;  ///< accepted position; `nullopt`: no sample may be used in this cycle
  };

  explicit Supervisor(const Config& config) : config_(config) {}

  /// Changes the limits from the next cycle on. Resets the count of lost samples (lost_tenths_); all other
  /// counters and timers continue.
  void retune(const Config& config);
  /// Called before the axis is driven: resets all counters and timers.
  void restart();
  /// Checks the received data. Called once in each cycle of a driven axis, before its command. `course_um`:
  /// smallest and largest possible motion since the last accepted sample, computed from the drive (Course).
  Verdict judge(const AxisInput& input, const model::Interval& course_um = {0.0, 0.0});
  /// Called once in each cycle of a driven axis, with the decided command and its active limits (gate.h).
  /// Returns the cause if the safe command must replace the command, or Cause::none.
  Cause watch(const AxisCommand& command, std::uint8_t limits, double dt_s);

  /// True if the amplifier has reported "enabled" since Enable was first commanded.
  bool enable_reported() const { return enable_reported_; }
  double enabled_for_s() const { return enabled_for_s_; }  ///< time since Enable was first commanded

 private:
  Cause judge_health(const AxisInput& input);
  bool has_lost_enable(const NodeHealth& health);
  Verdict judge_sample(const AxisInput& input, const model::Interval& course_um);
  Cause count_missing_sample(const AxisInput& input);
  Cause count_lost_sample(Cause cause);
  bool has_jumped(double position_um, const model::Interval& course_um) const;
  bool is_frozen(double position_um);

  Config config_;
  /// The count of lost samples, in tenths: each lost sample adds ten tenths, each good sample removes one
  /// tenth. So single lost samples are tolerated, and several lost samples in a row trip the axis.
  unsigned lost_tenths_ = 0;
  struct Lost {
    /// Numbers of consecutive lost samples: in total, and by reason. `late`: the sample arrived after its
    /// cycle. `in_long_cycles`: it was lost in a cycle with omitted SYNCs. `jumped`: its position is too far
    /// from the last accepted position.
    unsigned all = 0, late = 0, in_long_cycles = 0, jumped = 0;
  };
  Lost lost_in_a_row_;
  std::optional<double> last_um_;  ///< the last accepted sample
  unsigned cycles_since_last_ = 0;
  unsigned cycles_unchanged_ = 0;
  double travel_ = 0.0;  ///< travel of the drive while the position has not changed
  double last_drive_ = 0.0;
  double enabled_for_s_ = 0.0;
  bool enable_reported_ = false;
  double saturated_for_s_ = 0.0;
  double passive_for_s_ = 0.0;
  unsigned not_invertible_ = 0;  ///< consecutive cycles in which the model could not be inverted
};

}  // namespace hystcan::controller
