#include "model/any_model.h"

#include <gtest/gtest.h>

#include <variant>

#include "tests/model/models.h"

namespace hystcan::model::output_unit_test {
namespace {

TEST(OutputUnit, HasAFactorToMicrometresIfItIsALength) {
  EXPECT_EQ(length_um("nm"), 1e-3);
  EXPECT_EQ(length_um("um"), 1.0);
  EXPECT_EQ(length_um("\u00b5m"), 1.0);
  EXPECT_EQ(length_um("mm"), 1e3);
  EXPECT_EQ(length_um("m"), 1e6);
  for (const char* unit : {"", "T", "V", "UM", "nm ", "deg"}) EXPECT_FALSE(length_um(unit)) << unit;
}

TEST(OutputUnit, ConvertsAModelFromNanometresToMicrometres) {
  const Hysteresis um(piezo_model());
  HysteresisParameters given = piezo_model();
  given.output_unit = "nm";
  for (ReferenceCurve* curve : {&given.ascending, &given.descending}) {
    std::vector<double> coefficients = curve->coefficients();
    for (double& c : coefficients) c *= 1e3;
    *curve = curve->with(coefficients);
  }
  const AnyModel converted = model_of(in_um(given));
  const Hysteresis& model = std::get<Hysteresis>(converted);
  EXPECT_EQ(model.parameters().output_unit, "um");
  HysteresisState a = um.at_lower_threshold(), b = model.at_lower_threshold();
  for (const double v : long_walk(um.input_range(), 200, 3))
    ASSERT_NEAR(um.advance(a, v).value, model.advance(b, v).value, 1e-12 * 30.0);
}

TEST(OutputUnit, ScalesOffsetGainAndWeightsOfOperators) {
  const PrandtlIshlinskiiParameters given{"V", "mm", {0.0, 10.0}, 1.0, 2.0, {1.0}, {0.5}};
  const AnyParameters converted = in_um(given);
  const auto& p = std::get<PrandtlIshlinskiiParameters>(converted);
  EXPECT_EQ(p.offset, 1e3);
  EXPECT_EQ(p.gain, 2e3);
  EXPECT_EQ(p.weights.front(), 500.0);
  EXPECT_EQ(p.thresholds.front(), 1.0) << "an input";
}

TEST(OutputUnit, KeepsAUnitThatIsNotALength) {
  HysteresisParameters given = piezo_model();
  given.output_unit = "T";
  EXPECT_EQ(output_unit(in_um(given)), "T");
}

}  // namespace
}  // namespace hystcan::model::output_unit_test
