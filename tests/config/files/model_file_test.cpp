#include "config/files/model_file.h"
#include "base/error.h"

#include <gtest/gtest.h>

#include <fstream>

#include "config/files/memory_file.h"
#include "tests/support/refusal.h"
#include "tests/support/scratch.h"

namespace hystcan::config::model_file_test {
namespace {

constexpr const char* expected_text = R"(format = 1

[hysteresis]
kind         = "recursive-memory"
input_unit   = "V"
output_unit  = "um"
input_min    = 0.10000000000000001
input_max    = 100
basis        = "chebyshev"
ascending    = [5, 4.9000000000000004, -0.10000000000000001]
descending   = [5.2000000000000002, 4.9000000000000004, -0.29999999999999999]
k_ascending  = 0.0037000000000000002
k_descending = 0.033333333333333333
symmetry     = "even"

[identification]
samples      = 12345
delay_s      = 0.00125  # delay of the output behind the input
rms_percent  = 0.1235  # RMS error, relative to the output span of the dataset
max_percent  = 12
)";

model::HysteresisParameters written_parameters() {
  const model::Interval range{0.1, 100.0};
  return {.input_unit = "V",
          .output_unit = "um",
          .ascending = {model::Basis::chebyshev, {5.0, 4.9, -0.1}, range},
          .descending = {model::Basis::chebyshev, {5.2, 4.9, -0.3}, range},
          .k_ascending = 0.0037,
          .k_descending = 1.0 / 30.0,
          .symmetry = model::Symmetry::even};
}

constexpr IdentifiedFrom identified_from{
    .samples = 12345, .delay_s = 0.00125, .rms_percent = 0.123456, .max_percent = 12.0};

TEST(ModelText, IsThisFileToTheByte) {
  EXPECT_EQ(model_text(written_parameters(), identified_from), expected_text);
}

TEST(ModelText, ContainsTheOutputMapOfAButterfly) {
  model::HysteresisParameters given = written_parameters();
  given.symmetry = model::Symmetry::none;
  const std::vector<double> map{15.0, 0.25, 15.125};
  given.output_map.emplace(map, model::Interval{given.ascending.value(0.1), given.upper_point().level});
  const auto file = support::scratch_file("model.toml");
  std::ofstream(file) << model_text(given, identified_from);
  const model::HysteresisParameters found = load_model(file);
  ASSERT_TRUE(found.output_map);
  EXPECT_EQ(found.output_map->coefficients(), map);
  EXPECT_EQ(found.output_map->inner().lo, given.output_map->inner().lo);
}

TEST(ModelText, PreservesDynamics) {
  const auto file = support::scratch_file("model.toml");
  const model::Dynamics given{{512.25, 1.0 / 30.0}, 0.0003125};
  std::ofstream(file) << model_text(written_parameters(), identified_from, given);
  EXPECT_EQ(load_lag(file).dynamics, given);
  EXPECT_NO_THROW(load_model(file));
}

TEST(ModelText, PreservesCreep) {
  const auto file = support::scratch_file("model.toml");
  const model::OutputCreep::Config given{.per_decade = 0.07 / 3.0, .from_s = 1.0 / 128.0, .to_s = 7.0};
  std::ofstream(file) << model_text(written_parameters(), identified_from, {}, given);
  EXPECT_EQ(load_lag(file).creep, given);
  EXPECT_NO_THROW(load_model(file));
}

TEST(ModelFile, HasNoDynamicsAndCreepByDefault) {
  const auto file = support::scratch_file("model.toml");
  std::ofstream(file) << expected_text;
  EXPECT_FALSE(load_lag(file).dynamics);
  EXPECT_FALSE(load_lag(file).creep);
}

TEST(CreepMemoryText, ReadsBackToTheSameBits) {
  const auto file = support::scratch_file("memory.toml");
  const model::OutputCreep creep({.per_decade = 0.02});
  const model::HeldCreep::State given{
      .creep = {{1.0 / 3.0, -2.0, 1e-300, 0.1, 12345.678901234567, 3e22}}, .h = 7.0, .time_s = 0.1 + 0.2};
  std::ofstream(file) << "[memory]\nkind = \"recursive-memory\"\norigin = \"virgin\"\ninput = 3\n"
                      << creep_memory_text(given);
  const auto found = load_creep_memory(file, creep, 7.0);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->creep, given.creep);
  EXPECT_EQ(found->h, given.h);
  EXPECT_EQ(found->time_s, given.time_s);
}

TEST(StateFile, RefusesCreepAtItsKey) {
  const auto file = support::scratch_file("state.toml");
  std::ofstream(file)
      << "[memory]\nkind = \"recursive-memory\"\norigin = \"virgin\"\ninput = 3\ncreep = [1]\n"
         "[stop]\nreason = \"command\"\n";
  const std::string refusal =
      support::refusal_of([&] { load_state(file, model::Hysteresis(written_parameters())); });
  EXPECT_NE(refusal.find(":5:9: creep is not allowed in a state file"), std::string::npos) << refusal;
}

TEST(StateFile, AcceptsTheCorrectionOfAnEarlierVersion) {
  const auto file = support::scratch_file("state.toml");
  std::ofstream(file) << "[correction]\ngain = 1.0\noffset_um = 0.0\n"
                         "[memory]\nkind = \"recursive-memory\"\norigin = \"virgin\"\ninput = 3\n"
                         "[stop]\nreason = \"command\"\n";
  EXPECT_EQ(load_state(file, model::Hysteresis(written_parameters())).memory.input, 3.0);
}

TEST(ModelFile, RefusesAnOutputMapWithACrestAtItsKey) {
  const auto file = support::scratch_file("model.toml");
  std::string text = expected_text;
  text.insert(text.find("symmetry"), "output_map = [0, 0, -1]\n");
  std::ofstream(file) << text;
  const std::string refusal = support::refusal_of([&] { load_model(file); });
  EXPECT_NE(refusal.find("14:14: output map falls at"), std::string::npos) << refusal;
}

TEST(ModelText, PreservesPolynomialsToTheBit) {
  const auto file = support::scratch_file("model.toml");
  std::ofstream(file) << expected_text;
  const model::HysteresisParameters expected = written_parameters();
  const auto found = std::get<model::HysteresisParameters>(load_any_parameters(file));
  EXPECT_EQ(found.ascending.coefficients(), expected.ascending.coefficients());
  EXPECT_EQ(found.descending.coefficients(), expected.descending.coefficients());
  EXPECT_EQ(found.input_range().lo, expected.input_range().lo);
  EXPECT_EQ(found.input_range().hi, expected.input_range().hi);
  EXPECT_EQ(found.k_ascending, expected.k_ascending);
  EXPECT_EQ(found.k_descending, expected.k_descending);
  EXPECT_EQ(found.symmetry, expected.symmetry);
  EXPECT_EQ(load_lag(file).delay_s, identified_from.delay_s);
}

std::filesystem::path written(const std::string& text) {
  const auto file = support::scratch_file("model.toml");
  std::ofstream(file) << text;
  return file;
}

TEST(ModelText, PreservesSplinesToTheBit) {
  model::HysteresisParameters expected = written_parameters();
  const std::vector<double> knots{0.1, 1.0 / 3.0, 70.0, 99.0};
  const auto curve = [&](std::vector<double> c) {
    return model::ReferenceCurve(model::CubicSpline(knots, std::move(c)), expected.input_range());
  };
  expected.ascending = curve({0.0, 0.1, 2.0, 5.0, 9.0, 10.0});
  expected.descending = curve({0.3, 0.4, 2.3, 5.1, 9.0, 10.0});
  expected.k_ascending = expected.k_descending = 0.0;
  const auto file = written(model_text(expected, identified_from));
  const auto found = load_model(file);
  EXPECT_EQ(found.ascending.basis(), model::Basis::spline);
  EXPECT_EQ(found.ascending.knots(), knots);
  EXPECT_EQ(found.ascending.coefficients(), expected.ascending.coefficients());
  EXPECT_EQ(found.descending.coefficients(), expected.descending.coefficients());
}

TEST(ModelText, PreservesAnInputMapToTheBit) {
  model::HysteresisParameters given = written_parameters();
  const std::vector<double> knots{0.1, 70.0, 99.0}, map{0.1, 0.2, 1.0 / 3.0, 98.0, 99.0};
  const auto curve = [&](std::vector<double> c) {
    return model::ReferenceCurve(model::CubicSpline(knots, std::move(c)), {0.1, 99.0});
  };
  given.ascending = curve({0.0, 1.0, 2.0, 3.0, 4.0});
  given.descending = given.ascending;
  given.k_ascending = given.k_descending = 0.0;
  given.input_map.emplace(knots, map);
  const model::HysteresisParameters found = load_model(written(model_text(given, identified_from)));
  ASSERT_TRUE(found.input_map);
  EXPECT_EQ(found.input_map->coefficients(), map);
  EXPECT_EQ(found.input_map->knots(), knots);
}

/// Returns the refusal of a model of splines with these lines.
std::string refusal_of_splines(const std::string& lines) {
  const auto file = written(R"(
[hysteresis]
kind         = "recursive-memory"
input_unit   = "V"
output_unit  = "um"
input_min    = 0.0
input_max    = 10.0
basis        = "spline"
)" + lines + R"(
k_ascending  = 0.0
k_descending = 0.0
symmetry     = "none"
)");
  return support::refusal_of([&] { load_model(file); });
}

TEST(ModelFile, RefusesAnInputMapThatFallsAtItsKey) {
  const std::string said = refusal_of_splines(R"(knots        = [0.0, 5.0, 10.0]
ascending    = [0.0, 1.0, 2.0, 3.0, 4.0]
descending   = [0.0, 1.0, 2.0, 3.0, 4.0]
input_map    = [0.0, 2.0, 2.0, 8.0, 10.0])");
  EXPECT_NE(said.find(":12:16: input_map is not increasing, expected"), std::string::npos) << said;
}

TEST(ModelFile, RefusesASplineWithKnotsInTheWrongOrderAtItsCurve) {
  const std::string said = refusal_of_splines(R"(knots        = [0.0, 6.0, 5.0, 10.0]
ascending    = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
descending   = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0])");
  EXPECT_NE(said.find(":10:"), std::string::npos) << said;
  EXPECT_NE(said.find("spline knot 5 after 6"), std::string::npos) << said;
}

}  // namespace
}  // namespace hystcan::config::model_file_test
