// Explicit memories, and memories that are saved as text and restored.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "model/linear_mapping.h"
#include "model/preisach.h"
#include "tests/model/models.h"
#include "tests/model/saved_text.h"

namespace hystcan::model::memory_test {
namespace {

TurningPoints read(const std::string& text) {
  const std::string origin = value_of(text, "origin");
  return {origin == "\"virgin\""            ? Origin::virgin
          : origin == "\"lower-threshold\"" ? Origin::lower_threshold
                                            : Origin::upper_threshold,
          numbers_of(text, "turning_inputs"),
          numbers_of(text, "turning_outputs"),
          number_of(text, "input"),
          number_of(text, "output"),
          static_cast<std::size_t>(std::strtoull(value_of(text, "merged").c_str(), nullptr, 10))};
}

template <class Model>
std::string saved(const Model& model, const HysteresisState& state) {
  std::vector<char> buffer(Model::saved_size(state.branches.capacity()));
  return std::string(model.save(state, buffer));
}

template <class Model>
void is_restored_to_the_bit(const Model& model, std::size_t capacity) {
  const auto walk = random_walk(model.input_range(), 30);
  HysteresisState state = model.virgin(walk[0], capacity);
  for (const double v : walk) {
    model.advance(state, v);
    const HysteresisState restored = model.remembering(read(saved(model, state)), capacity);
    RC_ASSERT(same_bits(restored, state));
  }
}

TEST(SavedMemory, IsRestoredToTheBit) {
  EXPECT_TRUE(rc::check("recursive-memory", [] {
    is_restored_to_the_bit(Hysteresis(RandomModel::draw()), *rc::gen::element<std::size_t>(4, 5, 256));
  }));
  EXPECT_TRUE(rc::check("linear-mapping", [] {
    is_restored_to_the_bit(LinearMapping(RandomModel::draw()), *rc::gen::element<std::size_t>(4, 256));
  }));
  EXPECT_TRUE(rc::check("preisach", [] {
    is_restored_to_the_bit(Preisach({"V", "um", {-1.0, 4.0}, 0.5, 0.1, {1.0, 0.0, 0.3, 0.2, 0.7, 2.0}}),
                           *rc::gen::element<std::size_t>(4, 256));
  }));
  EXPECT_TRUE(rc::check("an even model", [] { is_restored_to_the_bit(Hysteresis(galfenol_model()), 256); }));
}

TEST(SavedMemory, IsATomlTable) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.at_lower_threshold();
  for (const double v : {80.0, 20.5, 60.0}) model.advance(state, v);
  const std::string text = saved(model, state);
  EXPECT_EQ(text.find("[memory]\nkind = \"recursive-memory\"\nmodel = \""), 0u) << text;
  EXPECT_EQ(value_of(text, "model").size(), 18u) << text;
  EXPECT_EQ(value_of(text, "origin"), "\"lower-threshold\"");
  EXPECT_EQ(value_of(text, "turning_inputs"), "[80.0, 20.5]");
  EXPECT_EQ(value_of(text, "input"), "60.0");
  EXPECT_EQ(value_of(text, "merged"), "0");
}

TEST(SavedMemory, FitsTheStatedSizeAndIsEmptyIfTheBufferIsTooSmall) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.at_lower_threshold(40);
  for (int i = 0; i < 60; ++i)
    model.advance(state, 50.0 + (i % 2 == 0 ? 1 : -1) * 49.0 / std::exp(0.1 * i) * (1 + 1e-13));
  ASSERT_TRUE(state.branches.full());
  const std::string text = saved(model, state);
  EXPECT_GT(text.size(), 40u * 40u);
  std::vector<char> exact(text.size()), small(text.size() - 1);
  EXPECT_EQ(model.save(state, exact), text);
  EXPECT_EQ(model.save(state, small), "");
  EXPECT_EQ(model.save(state, {}), "");
}

TEST(Fingerprint, DiffersBetweenModels) {
  const HysteresisParameters piezo = piezo_model();
  const auto of = [](const HysteresisParameters& p) { return Hysteresis(p).fingerprint(); };
  const std::uint64_t own = of(piezo);
  EXPECT_EQ(own, of(piezo_model()));
  HysteresisParameters other = piezo;
  other.k_ascending = std::nextafter(piezo.k_ascending, 1.0);
  EXPECT_NE(own, of(other));
  other = piezo;
  other.output_unit = "nm";
  EXPECT_NE(own, of(other));
  other = piezo;
  other.symmetry = Symmetry::even;
  EXPECT_NE(own, of(other));
  other = piezo;
  std::swap(other.k_ascending, other.k_descending);
  EXPECT_NE(own, of(other));
  EXPECT_NE(own, LinearMapping(piezo).fingerprint());
}

TEST(ExplicitMemory, EqualsTheMemoryOfADriveThroughItsTurningPoints) {
  const Hysteresis model(piezo_model());
  for (const Origin origin : {Origin::virgin, Origin::lower_threshold, Origin::upper_threshold}) {
    HysteresisState driven = origin == Origin::virgin            ? model.virgin(0.0)
                             : origin == Origin::lower_threshold ? model.at_lower_threshold()
                                                                 : model.at_upper_threshold();
    std::vector<double> turns{80.0, 20.0, 70.0};
    if (origin == Origin::upper_threshold) turns.insert(turns.begin(), 10.0);
    for (const double v : turns) model.advance(driven, v);
    model.advance(driven, 45.0);
    EXPECT_TRUE(same_bits(model.remembering({origin, turns, {}, 45.0, {}, 0}), driven));
  }
}

TEST(ExplicitMemory, IsFoldedIfSymmetryIsEven) {
  const Hysteresis model(galfenol_model());
  const HysteresisState plus = model.remembering({Origin::virgin, {2.0, 1.0}, {}, 1.5, {}, 0});
  const HysteresisState minus = model.remembering({Origin::virgin, {-2.0, 1.0}, {}, -1.5, {}, 0});
  EXPECT_TRUE(same_bits(plus, minus));
}

struct Refusal {
  const char* name;
  TurningPoints points;
  std::size_t index;
  const char* message;

  friend void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }
};

class ExplicitMemoryRefusals : public testing::TestWithParam<Refusal> {};

TEST_P(ExplicitMemoryRefusals, NameTheTurningPoint) {
  const auto& [name, points, index, message] = GetParam();
  try {
    Hysteresis(piezo_model()).remembering(points, 6);
    ADD_FAILURE() << name << " was not refused";
  } catch (const MemoryError& error) {
    EXPECT_EQ(error.index, index) << error.what();
    EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
  }
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
INSTANTIATE_TEST_SUITE_P(
    Of, ExplicitMemoryRefusals,
    testing::Values(
        Refusal{"NotNested",
                {Origin::virgin, {80, 20, 85}, {}, 50, {}, 0},
                2,
                "between the two previous ones, 20"},
        Refusal{"NotTurning", {Origin::virgin, {20, 80}, {}, 50, {}, 0}, 1, "between the two previous ones"},
        Refusal{"Outside", {Origin::lower_threshold, {101}, {}, 50, {}, 0}, 0, "100"},
        Refusal{"ThresholdItself", {Origin::upper_threshold, {0}, {}, 50, {}, 0}, 0, "strictly"},
        Refusal{"NotANumber", {Origin::virgin, {80, nan}, {}, 50, {}, 0}, 1, "nan"},
        Refusal{"InputElsewhere", {Origin::virgin, {80, 20}, {}, 10, {}, 0}, 2, "input is 10"},
        Refusal{"TooMany", {Origin::virgin, {90, 10, 80, 20, 70, 30}, {}, 50, {}, 0}, 5, "at most as many"},
        Refusal{"ForeignOutput", {Origin::virgin, {80, 20}, {25.0, 9.0}, 50, {}, 0}, 0, "another model"},
        Refusal{"OutputsMissing",
                {Origin::virgin, {80, 20}, {25.0}, 50, {}, 0},
                2,
                "one output for each turning point or no output"},
        Refusal{"ForeignOutputAtRest", {Origin::lower_threshold, {}, {}, 0, 77.0, 0}, 0, "another model"},
        Refusal{"ForeignPresentOutput", {Origin::virgin, {80}, {}, 50, 3.0, 0}, 1, "another model"}),
    [](const auto& test) { return test.param.name; });

TEST(ReachableRange, ContainsTheOutputsThatTheInverseReachesWithoutSaturation) {
  EXPECT_TRUE(rc::check("its ends are reached; outputs slightly beyond them saturate", [] {
    const Hysteresis model(RandomModel::draw());
    const auto walk = random_walk(model.input_range(), 10);
    HysteresisState state = model.virgin(walk[0]);
    for (const double v : walk) model.advance(state, v);
    const Interval reach = model.reachable(state);
    const double beyond = 1e-9 * model.output_range().span();
    RC_ASSERT(!model.inverse(state, reach.lo).saturated);
    RC_ASSERT(!model.inverse(state, reach.hi).saturated);
    RC_ASSERT(model.inverse(state, reach.lo - beyond).saturated);
    RC_ASSERT(model.inverse(state, reach.hi + beyond).saturated);
  }));
}

TEST(ReachableRange, EndsAtTheOutputsOfTheEndsOfALimitedDrive) {
  const Hysteresis model(piezo_model());
  HysteresisState state = model.at_lower_threshold();
  for (const double v : {80.0, 20.0, 60.0}) model.advance(state, v);
  const Interval reach = model.reachable(state, {10.0, 90.0});
  EXPECT_EQ(reach.lo, model.forward(state, 10.0).value);
  EXPECT_EQ(reach.hi, model.forward(state, 90.0).value);
  EXPECT_NEAR(model.inverse(state, reach.hi).value, 90.0, 1e-11);
}

}  // namespace
}  // namespace hystcan::model::memory_test
