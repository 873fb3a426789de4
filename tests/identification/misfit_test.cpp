// The residual of a model on its records, over the distance travelled by the input.
#include "identification/misfit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "identification/identify.h"
#include "model/hysteresis.h"
#include "tests/model/models.h"

namespace hystcan::identification::misfit_test {
namespace {

TEST(Misfit, ShowsAWaveOverTheTravelInItsOctave) {
  const model::Hysteresis truth(model::piezo_model());
  const double wave_um = 0.2, per_V = 0.1;  // one wave per 10 V
  model::HysteresisState state = truth.at_lower_threshold();
  Dataset record{"V", "um", {}, {}, {}};
  double travelled = 0.0, last = 0.0;
  for (int i = 0; i < 8000; ++i) {
    const double v = 50.0 - 50.0 * std::cos(2.0 * std::numbers::pi * i / 1000.0);
    travelled += std::abs(v - last);
    last = v;
    record.time_s.push_back(1e-3 * i);
    record.input.push_back(v);
    record.output.push_back(truth.advance(state, v).value +
                            wave_um * std::sin(2.0 * std::numbers::pi * per_V * travelled));
  }
  Identified found;
  found.parameters = truth.parameters();
  found.memories = {{InitialMemory::Kind::from_lower, 0.0}};
  found.offsets = found.drifts = {0.0};
  found.gains = {1.0};
  found.datasets = {Characterisation{}};
  found.held_out_rms = 0.15;
  const Misfit misfit = misfit_of(found, {record});
  const auto largest = std::ranges::max_element(misfit.rms) - misfit.rms.begin();
  const double middle = misfit.middle(static_cast<std::size_t>(largest));
  EXPECT_GT(middle, per_V / 3.0);
  EXPECT_LT(middle, per_V * 3.0);
  double square = 0.0;
  for (const double of : misfit.rms) square += of * of;
  EXPECT_NEAR(std::sqrt(square), 0.15, 1e-9) << "as large as the error of what was held out";
  EXPECT_NEAR(misfit.speed, 200.0, 2.0) << "V/s";
}

}  // namespace
}  // namespace hystcan::identification::misfit_test
