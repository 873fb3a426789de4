// Predicts the true error e of a loop on the real stage, and the interval that contains e for nine of ten
// stages. The sums are over the octaves b of the misfit (identification/misfit.h): q_b is the middle of an
// octave, r_b its RMS, and u the speed of the drive, so that q_b u is a frequency.
//
//   e^2 = x^2 + m^2 + f^2 + c^2
//
//   x  error in a rehearsal with an actuator that is exactly the model. If no record shows the mode, or if
//      the sensor's share of a delay is not stated: eleven rehearsals, each with another mode and share
//   m  the misfit between the model and its records (identification/misfit.h), shifted in frequency according
//      to the speed of the drive and multiplied by the loop's sensitivity S; without records, the error that
//      the twin's actuator adds to x:
//        m^2 = 1.2 sum_b |S(q_b u)|^2 r_b^2
//      The factor accounts for a reference that differs from the record.
//   f  an error that no loop removes, because the residual of slow loops is coarser than that of fast motion:
//        f^2 = 0.08 sum_b r_b^2
//   c  creep, extrapolated from slow records: a share of the travel that creeps in a decade, times |S| at the
//      reference's fundamental frequency
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

/// The unknown part of the dynamics of an axis.
struct Uncertainty {
  double unshared_s = 0.0;    ///< delay of which the sensor's share is not stated; 0: none
  double sensor_share = 0.0;  ///< share of this delay, 0 to 1, that is assigned to the sensor
  double share_error = 0.0;   ///< standard error of sensor_share
  double mode_error = 0.0;    ///< relative standard error of the resonance; 0: a record shows the mode
};

/// The basis of a promise for an axis, in addition to the rehearsals.
struct PromiseBasis {
  std::string loop;  ///< name of the loop
  std::optional<identification::Misfit> misfit{};
  Uncertainty uncertainty{};
};
/// Returns the basis for axis i, with the misfit from its model file.
PromiseBasis basis_of(const config::Config& config, std::size_t i, std::string loop,
                      const Uncertainty& uncertainty = {});

struct Promise {
  std::string axis, loop;
  double rms_um = 0.0;                   ///< expected true error, RMS
  double least_um = 0.0, most_um = 0.0;  ///< bounds of the 90 % interval
  double stroke_um = 0.0;
  /// Reason why the rehearsal with the exact model ended early; x then comes from the twin's actuator. Empty:
  /// that rehearsal succeeded.
  std::string exact_failure{};

  double percent() const { return 100.0 * rms_um / stroke_um; }
};

/// Returns one promise for each axis of the setup, in its order. Throws RunError if an axis does not track,
/// or at a signal.
std::vector<Promise> promises_of(const rehearsal::Setup& setup, const std::vector<PromiseBasis>& bases);

/// Returns promises for the loops of a configuration, named after their structures. Empty if an axis does not
/// track.
std::vector<Promise> promises_of(const config::Config& config);

/// Returns a warning about exact_failure; empty if there is no failure.
std::string warning_of(const Promise& promise);
/// Returns, for example, "promise x: 0.78 um RMS true (90 %: 0.55 to 1.1), 0.40 % of stroke; cautious".
std::string text_of(const Promise& promise);
nlohmann::json to_json(const Promise& promise);

}  // namespace hystcan::app
