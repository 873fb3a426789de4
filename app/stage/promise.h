// The true error that a loop will have on the stage itself, and the interval that holds it for nine stages of
// ten.
//
//   e^2 = x^2 + m^2 + f^2 + c^2
//
//   x  a rehearsal with an actuator that is exactly the model. Where no record shows the mode, or nobody has
//      stated how much of a delay is the sensor's: eleven rehearsals with samples of both
//   m  what the model leaves of its records (identification/misfit.h), moved as fast as the reference moves
//      the drive and let through by the loop's sensitivity S; without records, what the twin's actuator adds
//      to x:
//        m^2 = 1.2 sum_b |S(q_b u)|^2 r_b^2
//      The factor: the reference does not repeat the record.
//   f  what no loop takes away, because the residual of slow loops is coarser than what a fast one leaves:
//        f^2 = 0.08 sum_b r_b^2
//   c  creep, which slow records extrapolate: a share of the travel that creeps in a decade, times |S| at the
//      reference's fundamental frequency
//
// Each part is lognormal about this and independent of the others. The promise is the median of e, the
// interval goes from 5 % to 95 %. All factors and spreads are the same for every stage.
// tests/app/command_line/any_new_stage_test.cpp shows the promise on stages drawn at random.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/schema/config.h"
#include "identification/misfit.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {

/// What is not known of the dynamics of an axis.
struct Doubt {
  double unshared_s = 0.0;    ///< delay, nobody has stated how much of it is the sensor's; 0: none
  double sensor_share = 0.0;  ///< of it, 0 to 1, that is taken as the sensor's
  double share_error = 0.0;   ///< standard error of that
  double mode_error = 0.0;  ///< standard error of the resonance, as a share of it; 0: a record shows the mode
};

/// What a promise for an axis rests on, beside the rehearsals.
struct Ground {
  std::string loop;  ///< what the loop is called
  std::optional<identification::Misfit> misfit{};
  Doubt doubt{};
};
/// Of axis i: with the misfit that its model file has.
Ground ground_of(const config::Config& config, std::size_t i, std::string loop, const Doubt& doubt = {});

struct Promise {
  std::string axis, loop;
  double rms_um = 0.0;                   ///< expected
  double least_um = 0.0, most_um = 0.0;  ///< 90 %
  double stroke_um = 0.0;
  /// Why the rehearsal with an actuator that is exactly the model ends early; x is then that of the twin's.
  /// Empty: it does not.
  std::string exact_failure{};

  double percent() const { return 100.0 * rms_um / stroke_um; }
};

/// One for each axis of the setup, in its order. Throws RunError where an axis does not track, or at a
/// signal.
std::vector<Promise> promises_of(const rehearsal::Setup& setup, const std::vector<Ground>& grounds);

/// With the loops of a configuration, which are called by their structures. Empty where an axis does not
/// track.
std::vector<Promise> promises_of(const config::Config& config);

/// A line about exact_failure; empty where there is none.
std::string warning_of(const Promise& promise);
/// "promise x: 0.78 um RMS true (90 %: 0.55 to 1.1), 0.40 % of stroke; cautious"
std::string text_of(const Promise& promise);
nlohmann::json to_json(const Promise& promise);

}  // namespace hystcan::app
