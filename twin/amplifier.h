// The drive amplifier: a first-order lag with a slew limit.
//
//   v' = clamp( omega (target - v), -slew, +slew ),   omega = 2 pi bandwidth
//
// Solved in closed form over a step of any length: a ramp while the slew limit holds, then an exponential.
// Between two changes of the target v is monotone, so that the hysteresis behind it turns only where the
// target changes.
#pragma once

namespace hystcan::twin {

struct Amplifier {
  struct Config {
    double drive_min = 0.0;  ///< output range, drive units
    double drive_max = 100.0;
    double slew_per_s = 1e5;     ///< drive units per second, > 0
    double bandwidth_Hz = 1000;  ///< small-signal, -3 dB, > 0
    double safe_drive = 0.0;     ///< where the output goes when nothing may be driven
  };
  struct State {
    double output = 0.0;  ///< v
    double target = 0.0;
  };
  /// The step of a fixed length, its decay computed once.
  class Step {
   public:
    Step(const Config& config, double dt_s);
    State operator()(const State& state) const;

   private:
    double dt_s_;
    double omega_;
    double slew_per_s_;
    double linear_error_;  ///< below it the lag is slower than the slew limit
    double decay_;         ///< e^{-omega dt}
  };
};

}  // namespace hystcan::twin
