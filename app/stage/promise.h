// Predicts the true error e of a loop on the real stage: a promise with an interval that contains e for nine
// of ten stages.
//
//   e^2 = x^2 + m^2 + f^2 + c^2
//
//   x  error in a rehearsal with an actuator that is exactly the model. If no record shows the mode, or if
//      the sensor's share of a delay is not stated: eleven rehearsals, each with another mode and share
//   m  error from the misfit between the model and its records (identification/misfit.h):
//        m^2 = 1.2 sum_b |S(q_b u)|^2 r_b^2
//      Without records, it is the error that the twin's actuator adds to x. The factor 1.2 accounts
//      for a reference that differs from the record.
//   f  share of the misfit that no loop removes, because the residuals of a fast motion have higher
//      frequencies than the records of slow loops show:
//        f^2 = 0.08 sum_b r_b^2
//   c  error from creep, extrapolated from slow records: a share of the travel that creeps in a decade,
//      times |S| at the reference's fundamental frequency
//
//   b  octave of the misfit; q_b is its middle, r_b its RMS. The sums end at half the resonance
//   u  speed of the drive; q_b u is a frequency
//   S  sensitivity of the loop: the share of a disturbance that remains
//
// Each part is lognormal around this value and independent of the others. The promise is the median of e; the
// interval is from 5 % to 95 %. All factors and spreads are the same for every stage.
// tests/app/command_line/any_new_stage_test.cpp checks the promise on randomly drawn stages.
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

/// The dynamics of an axis that neither the user nor a record determines.
struct Uncertainty {
  double unshared_s = 0.0;    ///< delay whose division between amplifier and sensor is unknown; 0: none
  double sensor_share = 0.0;  ///< share of the delay unshared_s that is assigned to the sensor, 0 to 1
  double share_error = 0.0;   ///< standard error of the sensor's share of the delay unshared_s
  double mode_error = 0.0;    ///< relative standard error of the resonance; 0: a record shows it
};

/// The input of the prediction for one axis, in addition to the rehearsals.
struct PromiseBasis {
  std::string loop;  ///< name of the loop, for the text of the promise
  std::optional<identification::Misfit> misfit{};
  Uncertainty uncertainty{};
};
/// Returns the data from which the promise for axis i is computed. Reads the misfit from the model file of
/// the axis. `loop`: name of the loop, for the text of the promise.
PromiseBasis basis_of(const config::Config& config, std::size_t i, std::string loop,
                      const Uncertainty& uncertainty = {});

struct Promise {
  std::string axis, loop;
  double rms_um = 0.0;                   ///< predicted true error, RMS
  double least_um = 0.0, most_um = 0.0;  ///< ends of the 90 % interval of the error
  double stroke_um = 0.0;
  /// Reason why the rehearsal with an actuator that equals the model failed; the prediction then uses the
  /// twin's actuator instead. Empty if this rehearsal succeeded.
  std::string exact_failure{};

  double percent() const { return 100.0 * rms_um / stroke_um; }
};

/// Returns a promise for each axis of the setup, in the same order. Throws RunError if an axis does not track
/// in the rehearsal, or at a signal.
std::vector<Promise> promises_of(const rehearsal::Setup& setup, const std::vector<PromiseBasis>& bases);

/// Returns promises for the configured loops. In a promise, the name of the loop is the structure of its
/// control law, for example "inverse+pi". Returns no promises if an axis does not track.
std::vector<Promise> promises_of(const config::Config& config);

/// Returns a warning if the rehearsal with an actuator that equals the model failed (exact_failure); an empty
/// text if this rehearsal succeeded.
std::string warning_of(const Promise& promise);
/// Returns a line such as "promise x: 0.78 um RMS true (90 %: 0.55 to 1.1), 0.40 % of stroke; cautious".
std::string text_of(const Promise& promise);
nlohmann::json to_json(const Promise& promise);

}  // namespace hystcan::app
