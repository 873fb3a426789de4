// Judges, cycle by cycle, whether a driven axis may go on being driven. Pure: told what was heard and what
// was commanded.
//
//   sample     a lost, late or jumped one is bridged and fills a leaky bucket; a run of them trips
//   jump       |y - y_last| > position_jump_um for each cycle since y_last, the last sample taken: a stage
//   that is
//              really elsewhere is let in later, and judged by its following error
//   frozen     y is the same to the last bit for frozen_cycles, in which the drive went further than a
//              fiftieth of its range: noise and stage would have moved any real sensor
//   saturated  the drive is limited, by range, slew or the model's thresholds, for saturated_s on end
//
// Where several things are wrong at once, the most telling one is the cause.
#pragma once

#include <cstdint>
#include <optional>

#include "controller/control/fault.h"

namespace hystcan::controller {

/// What is known of the axis's two nodes when a cycle is decided.
struct NodeHealth {
  bool interface_up = true;
  bool bus_on = true;         ///< not bus-off
  bool bus_passive = false;   ///< our own CAN controller is error-passive
  bool sensor_alive = false;  ///< heartbeat heard in time
  bool sensor_operational = false;
  bool amplifier_alive = false;
  bool amplifier_operational = false;
  bool restarted = false;          ///< a node booted up since the last cycle
  bool emergency = false;          ///< a node sent one, of another code than "no error", since the last cycle
  bool amplifier_ready = false;    ///< last status: ready or enabled
  bool amplifier_enabled = false;  ///< last status: enabled
  bool amplifier_fault = false;    ///< last status: fault
  double amplifier_output = 0.0;   ///< last status, drive units
  bool amplifier_moves = false;    ///< switched off, and not yet told to rest
};

struct AxisInput {
  double time_s = 0.0;                ///< of this cycle's SYNC, since the controller's start
  double dt_s = 0.0;                  ///< since the last cycle's SYNC
  double cycle_s = 0.0;               ///< the nominal period
  std::optional<double> position_um;  ///< empty: no sample came
  bool sensor_status_good = true;
  bool late_sample = false;     ///< one of an earlier cycle came since the last step
  bool begin_tracking = false;  ///< every axis is ready
  double coupled_um = 0.0;      ///< what the other axes will add to the position
  NodeHealth health;
};

struct AxisCommand {
  double drive = 0.0;
  bool enable = false;
  bool clear_fault = false;
};

/// Fills by one for every lost sample, leaks by a tenth for every good one: single losses are bridged, a run
/// trips.
class LeakyBucket {
 public:
  explicit LeakyBucket(unsigned capacity) : capacity_(10 * capacity) {}
  void lose() { level_ += 10; }
  void leak() { level_ -= level_ > 0 ? 1 : 0; }
  void empty() { level_ = 0; }
  bool overflows() const { return level_ > capacity_; }

 private:
  unsigned capacity_;
  unsigned level_ = 0;
};

class Supervisor {
 public:
  struct Config {
    double position_min_um = 0.0;  ///< outside: implausible, a broken sensor or stage
    double position_max_um = 0.0;
    double position_jump_um = 0.0;  ///< in one cycle; 0: not judged
    unsigned missing_samples = 3;   ///< bridged in a row; one more trips
    unsigned frozen_cycles = 50;    ///< 0: not judged
    double saturated_s = 2.0;       ///< 0: not judged
    double bus_passive_s = 0.5;     ///< 0: not judged
    double drive_range = 0.0;       ///< drive_max - drive_min, drive units
  };
  struct Verdict {
    Cause cause = Cause::none;
    std::optional<double> position_um;  ///< the sample, where it may be used
  };

  explicit Supervisor(const Config& config) : config_(config), lost_(config.missing_samples) {}

  /// Other limits from the next cycle on; what has been seen of the axis still counts.
  void retune(const Config& config);
  /// Nothing of the past counts: the axis is about to be driven.
  void restart();
  /// Once in each cycle of a driven axis, before its command.
  Verdict judge(const AxisInput& input);
  /// The command that was decided, and by what the law's wish was limited (gate.h): a cause to take it back.
  Cause judge(const AxisCommand& command, std::uint8_t limits, double dt_s);

 private:
  Cause judge_bus(const AxisInput& input);
  Cause judge_nodes(const AxisInput& input) const;
  Verdict judge_sample(const AxisInput& input);
  Cause lose(bool late, Cause cause);
  bool has_jumped(double position_um) const;
  bool is_frozen(double position_um);

  Config config_;
  LeakyBucket lost_;
  unsigned lost_in_a_row_ = 0;
  unsigned late_in_a_row_ = 0;
  std::optional<double> last_um_;  ///< the last sample taken
  unsigned cycles_since_last_ = 0;
  unsigned cycles_unchanged_ = 0;
  double travel_ = 0.0;  ///< of the drive, meanwhile
  double last_drive_ = 0.0;
  double enabled_for_s_ = 0.0;
  double saturated_for_s_ = 0.0;
  double passive_for_s_ = 0.0;
  unsigned not_invertible_ = 0;  ///< cycles in a row
};

}  // namespace hystcan::controller
