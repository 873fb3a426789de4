// The simulated drive amplifier: its limits, and its output as a closed formula of time.
#pragma once

#include <cstdint>
#include <limits>

namespace hystcan::twin {

// The output v of an amplifier whose target r moves in a straight line, r = target + rate t:
//
//   v' = omega e within  max(-slew, rho (-P - v)) <= omega e <= min(slew, rho (P - v)),   e = r - v
//   v' = the limit       otherwise                                       rho = R / L, P = V / R
//
// e is the error. omega is the corner frequency of the amplifier's lag, in 1/s. R and L are resistance and
// inductance of the load, V is the voltage limit, and `slew` is the slew limit. v passes through phases: lag,
// slew limit, voltage limit. In each phase v, e and the distance to every limit have the form g(t), with
// constants a, b, c and k:
//
//   g(t) = a + b t + c e^{-kt}
//
//   lag       v = r - rate / omega - (e(0) - rate / omega) e^{-omega t}
//   slew      v = v(0) +- slew t
//   voltage   v = +-P + (v(0) -+ P) e^{-rho t}
//
// A phase ends when the distance to a limit crosses zero. This distance is a g(t), which has at most one
// extremum, at a known time. So bisection finds the zero on a monotone part of g, up to rounding.
//
// v turns (v' changes its sign) if e = 0. At this time e' = rate, so e has the sign of the rate from then on:
// v turns at most once.

struct DriveLimits {
  double omega = 1.0;                                           ///< corner frequency of the lag, 1/s
  double slew_per_s = 1.0;                                      ///< slew limit, drive units per second
  double load_rate_per_s = 0.0;                                 ///< R / L of an inductive load (rho), 1/s
  double load_limit = std::numeric_limits<double>::infinity();  ///< largest current of an inductive load, A:
                                                                ///< voltage limit / resistance
};

// The drive amplifier: a first-order lag with limits.
//
//   v' = clamp( omega (target - v), -slew, +slew ),   omega = 2 pi bandwidth
//
// v is the output and `slew` its maximum rate. A capacitive load C or an inductive load L with a resistance R
// in series limits v' further (V: voltage limit):
//
//   capacitive, v in V   |C v'| <= current_limit            slew = min(slew, current_limit / C)
//   inductive, v in A    |L v' + R v| <= voltage_limit V    rising:   v' <= ( V - R v) / L
//                                                           falling:  v' >= (-V - R v) / L
//
// With an inductive load, v never reaches a target above V / R: v ends at V / R.
//
// The equation is solved in closed form over a step of any length, phase by phase (see struct DriveLimits).
// While the target is constant, v is monotone, so the input of the hysteresis turns only when the target
// changes. While the target moves in a straight line, v may turn once.
//
// When the amplifier is switched off, its power stage is disconnected and the load discharges itself:
//
//   v' = -v / tau,   tau = R C (R is a bleed resistor across C) or L / R (the current of L free-wheels)

/// Advances the amplifier by a time step of fixed length. The decay factors are computed once.
class Amplifier {
 public:
  static constexpr double unlimited = std::numeric_limits<double>::infinity();

  struct Config {
    double drive_min = 0.0;  ///< lower end of the output range, drive units
    double drive_max = 100.0;
    double slew_per_s = 1e5;             ///< maximum rate of the output, drive units per second, > 0
    double bandwidth_Hz = 1000;          ///< small-signal bandwidth (-3 dB), > 0
    double safe_drive = 0.0;             ///< output while the amplifier is disabled, drive units
    double current_limit_A = unlimited;  ///< maximum current into load_uF
    double voltage_limit_V = unlimited;  ///< maximum voltage across load_mH and load_ohm
    double load_uF = 0.0;                ///< capacitive load; 0: none
    double load_mH = 0.0;                ///< inductive load; 0: none
    double load_ohm = 0.0;               ///< resistance in series with load_mH, or parallel to load_uF, which
                                         ///< it discharges when the amplifier is off
    double resolution = 0.0;             ///< resolution of the target (DAC), drive units; 0: not quantised
    double ramp_per_s = unlimited;       ///< maximum rate of the output on its ramp to the safe drive
                                         ///< (Course::ramp), drive units per second
  };
  /// How the output moves to its target.
  enum class Course : std::uint8_t {
    drive,  ///< the output moves to the target as fast as the amplifier can
    ramp,   ///< the output moves to the target no faster than ramp_per_s
    off     ///< the power stage is disconnected: the load discharges to zero, independent of the target
  };
  struct State {
    double output = 0.0;  ///< present output (v), drive units
    double target = 0.0;  ///< present target (r), drive units
    Course course = Course::drive;
    double rate_per_s = 0.0;  ///< rate of change of the target, drive units per second

    /// Returns the output (v) after `time_s`, if it moves as fast as the amplifier can (Course::drive).
    double output_after(const DriveLimits& limits, double time_s) const;
    /// Returns the time until the output reverses its direction, if the output moves as fast as the amplifier
    /// can (Course::drive). Returns infinity if the output does not reverse within `time_s`.
    double turns_after_s(const DriveLimits& limits, double time_s) const;
  };

  /// Returns the target for a setpoint: the setpoint, rounded to the resolution and limited to the range.
  static double target_of(const Config& config, double setpoint);
  /// Returns the time constant of the load's discharge, in s; 0 if the load discharges at once.
  static double discharge_s(const Config& config);
  /// Returns the lag and the limits of an output that moves as fast as the amplifier can (Course::drive).
  static DriveLimits limits(const Config& config);

  Amplifier(const Config& config, double dt_s);
  State operator()(const State& state) const;

 private:
  static bool is_within(const DriveLimits& limits, const State& state);

  double dt_s_;
  DriveLimits limits_, ramp_limits_;
  double decay_;        ///< factor by which the error of the lag decays in one step
  double discharge_s_;  ///< time constant of the load's discharge
};

}  // namespace hystcan::twin
