// The plant of a loop from an identified mode.
//
// The fit knows a mode behind a pure delay and held drives (identification/dynamics/second_order_fit.h). The chain of the
// loop has the lags of amplifier and sensor instead, and its amplifier may interpolate: seen through the fit, such a chain
// has another delay and, near half the rate, another damping. So the chain is sought whose samples, driven as in the
// record, let the fit find what it has found (indirect inference: Gourieroux, Monfort, Renault, J. Appl. Econometrics 8,
// 1993):
//
//   f <- f f_found / f_seen,   zeta <- zeta zeta_found / zeta_seen,   lag <- lag + delay_found - delay_seen
#pragma once

#include "controller/analysis/loop_design.h"
#include "identification/dataset.h"
#include "identification/dynamics/second_order_fit.h"

namespace hystcan::app {

struct IdentifiedPlant {
  controller::Delays delays;
  controller::PlantUncertainty uncertainty;
};

/// `present` states the sensor and whether the amplifier interpolates. Only the sum of the delays can be identified: what
/// is more than these becomes the amplifier's lag, where it can be distinguished from zero; else that of `present` stays.
IdentifiedPlant identified_plant(const identification::Dataset& record,
                                 const identification::SecondOrderFit& fit,
                                 const controller::Delays& present);

}  // namespace hystcan::app
