// `hystcan identify` and `hystcan validate` as processes.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "identification/quasi_static.h"
#include "model/hysteresis.h"
#include "tests/app/command_line/cli.h"
#include "tests/identification/made_record.h"
#include "tests/support/piezo.h"

namespace hystcan::identify_test {
namespace {

using namespace identification;

// Percent of the output span, 30 um.
constexpr double percent_of_stroke = 100.0 / 30.0;

class Identify : public Cli {
 protected:
  Process run(const std::vector<std::string>& words) const {
    std::vector<std::string> all{HYSTCAN_PROGRAM, "identify"};
    all.insert(all.end(), words.begin(), words.end());
    return Process(all);
  }
  Process identify(const char* data, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{path(data), "--output", path("found.toml")};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  Process validate(const char* data, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{HYSTCAN_PROGRAM, "validate", path("found.toml"), path(data)};
    all.insert(all.end(), more.begin(), more.end());
    return Process(all);
  }

  /// Writes about 1500 rows of support::piezo_model().
  static Dataset piezo_record(double steps = 75.0) {
    return record_of(model::Hysteresis(support::piezo_model()), steps);
  }
  void write_record(const char* name, const Dataset& record, const std::string& before = "") const {
    std::ofstream out(shipped / name, std::ios::binary);
    out.precision(17);
    out << before << "time_s,input,output\n";
    for (std::size_t i = 0; i < record.size(); ++i)
      out << record.time_s[i] << ',' << record.input[i] << ',' << record.output[i] << '\n';
  }
  /// Expects exit status 2, one line, and no file.
  void expect_refused(Process program, const std::string& words) const {
    EXPECT_EQ(program.wait(), bad_input) << program.err();
    std::string said;  // beside assumed values
    std::istringstream lines(program.err());
    for (std::string line; std::getline(lines, line);)
      if (line.find(", assuming ") == std::string::npos) said += line + "\n";
    EXPECT_NE(said.find(words), std::string::npos) << said;
    EXPECT_EQ(std::ranges::count(said, '\n'), 1) << said;
    EXPECT_FALSE(std::filesystem::exists(shipped / "found.toml"));
  }
};

std::vector<double> outputs_of(const std::string& csv, int column) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  std::vector<double> outputs;
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::string field;
    for (int i = 0; i <= column; ++i) std::getline(fields, field, ',');
    outputs.push_back(std::stod(field));
  }
  return outputs;
}

double rms_between(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double square = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(square / static_cast<double>(b.size()));
}

TEST_F(Identify, WritesAValidModelThatRuns) {
  const Dataset record = piezo_record();
  write_record("record.csv", record);
  Process program = identify("record.csv");
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("found.toml: order "), std::string::npos) << program.out();
  Process check({HYSTCAN_PROGRAM, "check", path("found.toml")});
  EXPECT_EQ(check.wait(), done) << check.err();
  Process simulate({HYSTCAN_PROGRAM, "simulate", path("found.toml"), "--input", path("record.csv"),
                    "--output", path("simulated.csv")});
  ASSERT_EQ(simulate.wait(), done) << simulate.err();
  EXPECT_LT(rms_between(outputs_of(read("simulated.csv"), 2), record.output) * percent_of_stroke,
            1.0);  // without its memory
}

TEST_F(Identify, WritesItsModelIntoACopyOfTheConfiguration) {
  Process excite({HYSTCAN_PROGRAM, "excite", path("piezo.toml"), "--axis", "y", "--rehearse", "--period", "1",
                  "--output", path("y.csv")});
  ASSERT_EQ(excite.wait(), done) << excite.err();
  const std::string before = read("piezo.toml");
  Process program = identify("y.csv", {"--order", "3", "--thresholds", "observed", "--for",
                                       path("piezo.toml"), "--axis", "y", "--write", path("new.toml")});
  ASSERT_EQ(program.wait(), done) << program.err();
  std::string expected = before;
  const auto at = expected.rfind("\"piezo.model.toml\"");
  expected.replace(at, 18, "\"found.toml\"");
  EXPECT_EQ(read("new.toml"), expected) << "one line differs, comments are kept";
  EXPECT_EQ(read("piezo.toml"), before);
  Process again = identify("y.csv", {"--for", path("piezo.toml"), "--write", path("new.toml")});
  EXPECT_EQ(again.wait(), bad_input);
  EXPECT_NE(again.err().find("exists already"), std::string::npos) << again.err();
}

TEST_F(Identify, PrintsJson) {
  write_record("record.csv", piezo_record(), "# input_unit = V\n# output_unit = um\n");
  Process program = identify("record.csv", {"--json", "--order", "3"});
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_EQ(program.err(), "");
  const auto found = nlohmann::json::parse(program.out());
  EXPECT_EQ(found["order"], 3);
  EXPECT_LT(found["rms_percent"].get<double>(), 0.01);
  EXPECT_NEAR(found["k_ascending"].get<double>(), 0.035, 1e-3 * 0.035);
  EXPECT_EQ(found["stopped"], false);
  EXPECT_EQ(found["records"].size(), 1U);
  EXPECT_GE(found["findings"].size(), 3U);
}

TEST_F(Identify, WritesTheMemoryAtTheStartOfTheDataset) {
  const model::Hysteresis truth(support::piezo_model());
  model::HysteresisState state = truth.at_lower_threshold();
  for (const double v : {90.0, 20.0, 75.0, 45.0}) truth.advance(state, v);
  std::vector<double> points = loops_and_reversal_curves();
  points.insert(points.begin(), {0.45, 0.6, 0.3});
  const Dataset record = record_of(truth, state, travelled(in_range(points, {0.0, 100.0}), 1.0));
  write_record("record.csv", record);
  Process program = identify("record.csv", {"--initial-memory", path("begin.toml"), "--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_TRUE(read("begin.toml").starts_with("format = 1\n\n[memory]\n"));
  const auto found = nlohmann::json::parse(program.out());
  EXPECT_LT(found["rms_percent"], 0.2);
  Process simulate({HYSTCAN_PROGRAM, "simulate", path("found.toml"), "--input", path("record.csv"),
                    "--memory", path("begin.toml"), "--output", path("simulated.csv")});
  ASSERT_EQ(simulate.wait(), done) << simulate.err();
  EXPECT_NEAR(rms_between(outputs_of(read("simulated.csv"), 2), record.output) /
                  found["output_span"].get<double>() * 100.0,
              found["rms_percent"].get<double>(), 1e-3);
  Process again = validate("record.csv", {"--memory", path("begin.toml"), "--json"});
  ASSERT_EQ(again.wait(), done) << again.err();
  EXPECT_NEAR(nlohmann::json::parse(again.out())["rms_percent"].get<double>(),
              found["rms_percent"].get<double>(), 1e-3);
}

// An even model has the same memory at a negative input as at the positive one.
TEST_F(Identify, WritesTheMemoryOfADatasetThatBeginsAtANegativeInput) {
  model::HysteresisParameters even = support::piezo_model();
  even.symmetry = model::Symmetry::even;
  const model::Hysteresis truth(even);
  std::vector<double> inputs = travelled({-60.0, 100.0, -100.0, 70.0, -100.0, 40.0, -100.0, 100.0, 20.0,
                                          100.0, 50.0, 100.0, -100.0, -30.0, -100.0, 0.0},
                                         1.0);
  model::HysteresisState state = truth.at_upper_threshold();
  truth.advance(state, 60.0);
  const Dataset record = record_of(truth, state, inputs);
  write_record("record.csv", record);
  Process program = identify("record.csv", {"--initial-memory", path("begin.toml"), "--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto found = nlohmann::json::parse(program.out());
  Process again = validate("record.csv", {"--memory", path("begin.toml"), "--json"});
  ASSERT_EQ(again.wait(), done) << again.err();
  EXPECT_NEAR(nlohmann::json::parse(again.out())["rms_percent"].get<double>(),
              found["rms_percent"].get<double>(), 1e-3);
}

TEST_F(Identify, RefusesInvalidOptions) {
  write_record("record.csv", piezo_record(10.0));
  expect_refused(identify("record.csv", {"--from", "1000"}), "record.csv: no rows between --from and --to");
  expect_refused(identify("record.csv", {"--from", "0.1", "--to", "0.05"}),
                 "--from is 0.1, expected at most --to, 0.05");
  Process order = identify("record.csv", {"--order", "99"});
  EXPECT_EQ(order.wait(), bad_input);
  EXPECT_NE(order.err().find("99, expected auto or 1 to 20"), std::string::npos) << order.err();
  const std::string before = read("record.csv");
  Process overwriting = run({path("record.csv"), "--output", path("record.csv")});
  EXPECT_EQ(overwriting.wait(), bad_input);
  EXPECT_NE(overwriting.err().find("record.csv: is also an input, expected another file"), std::string::npos)
      << overwriting.err();
  EXPECT_EQ(read("record.csv"), before);
  expect_refused(identify("record.csv", {"--initial-memory", path("found.toml")}), "is written twice");
}

TEST_F(Identify, RefusesDatasetsOfDifferentUnits) {
  write_record("V.csv", piezo_record(10.0), "# input_unit = V\n# output_unit = um\n");
  write_record("A.csv", piezo_record(10.0), "# input_unit = A\n# output_unit = um\n");
  expect_refused(run({path("V.csv"), path("A.csv"), "--output", path("found.toml")}),
                 "A.csv: the units are A and um, expected V and um as in");
}

TEST_F(Identify, RefusesADatasetWithAnotherUnitThanTheOption) {
  write_record("A.csv", piezo_record(10.0), "# input_unit = A\n");
  expect_refused(run({path("A.csv"), "--output", path("found.toml"), "--input-unit", "V"}),
                 "A.csv: the file has input_unit = \"A\", expected \"V\"");
}

TEST_F(Identify, RefusesAUnitWithAControlCharacter) {
  write_record("esc.csv", piezo_record(10.0), "# input_unit = V\x1b[31m\n");
  expect_refused(identify("esc.csv"), "esc.csv: input_unit contains a control character");
  write_record("plain.csv", piezo_record(10.0));
  expect_refused(run({path("plain.csv"), "--output", path("found.toml"), "--output-unit", "um\n[creep]"}),
                 "plain.csv: --output-unit contains a control character");
}

TEST_F(Identify, ConvertsARecordInMicrometresToTheNanometresOfTheOldModel) {
  Dataset record = piezo_record(20.0);
  write_record("um.csv", record, "# input_unit = V\n# output_unit = um\n");
  for (double& value : record.output) value *= 1e3;
  write_record("nm.csv", record, "# input_unit = V\n# output_unit = nm\n");
  const auto identify_to = [&](const char* output, const std::vector<std::string>& words) {
    std::vector<std::string> all{"--json", "--order", "3", "--output", path(output)};
    all.insert(all.end(), words.begin(), words.end());
    Process program = run(all);
    EXPECT_EQ(program.wait(), done) << program.err();
    return nlohmann::json::parse(program.out());
  };
  identify_to("old.toml", {path("nm.csv")});
  const auto from_nm = identify_to("from_nm.toml", {path("nm.csv"), "--start", path("old.toml")});
  const auto from_um = identify_to("from_um.toml", {path("um.csv"), "--start", path("old.toml")});
  EXPECT_NEAR(from_um["rms_percent"].get<double>(), from_nm["rms_percent"].get<double>(), 1e-3);
  EXPECT_NE(read("from_um.toml").find("output_unit  = \"nm\""), std::string::npos);
}

TEST_F(Identify, NamesAnUnsuitableDataset) {
  Dataset record = piezo_record(10.0);
  std::ranges::fill(record.output, 5.0);
  write_record("flat.csv", record);
  expect_refused(identify("flat.csv"),
                 "flat.csv: the output is constant at 5, expected an output that follows the input");
}

TEST_F(Identify, StopsAtCtrlCWithTheBestModelSoFar) {
  const Dataset record = with_noise(piezo_record(15000.0), 0.03, 1);
  write_record("large.csv", record);
  Process program = identify("large.csv");
  ASSERT_TRUE(program.handles(SIGINT)) << program.err();
  program.send(SIGINT);
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("the search was stopped early: this is the best model so far"),
            std::string::npos)
      << program.out();
  EXPECT_NE(read("found.toml").find("the search was stopped early"), std::string::npos);
  Process check({HYSTCAN_PROGRAM, "check", path("found.toml")});
  EXPECT_EQ(check.wait(), done) << check.err();
}

/// Triangle of 50 Hz at 2 kHz, after a mode of 300 Hz and a delay.
Dataset fast_record() {
  const model::Hysteresis model(support::piezo_model());
  Dataset record{"V", "um", {}, {}, {}};
  std::vector<double> still;
  auto state = model.at_lower_threshold();
  for (int n = 0; n < 2400; ++n) {
    const int cycle = n / 40, step = n % 40;
    const double part = (step < 20 ? step : 40 - step) / 20.0;
    record.time_s.push_back(n * 5e-4);
    record.input.push_back(8.0 * (cycle % 5) + (100.0 - 16.0 * (cycle % 5)) * part);
    still.push_back(model.advance(state, record.input.back()).value);
  }
  record.output = respond({{300.0, 0.05}, 8e-4}, record.time_s, still);
  return with_noise(record, 0.003, 1);
}

TEST_F(Identify, WritesTheDynamicsThatValidateAndSimulateUse) {
  write_record("record.csv", fast_record(), "# input_unit = \"V\"\n# output_unit = \"um\"\n");
  Process program = identify("record.csv", {"--dynamics", "--order", "3", "--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto found = nlohmann::json::parse(program.out())["dynamics"];
  EXPECT_NEAR(found["resonance_Hz"], 300.0, 1.0);
  EXPECT_NEAR(found["damping_ratio"], 0.05, 0.002);
  EXPECT_NEAR(found["delay_s"], 8e-4, 5e-6);
  const auto rms_percent = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{HYSTCAN_PROGRAM, "validate", path("found.toml"), path("record.csv"),
                                   "--json"};
    words.insert(words.end(), more.begin(), more.end());
    Process validation(words);
    EXPECT_EQ(validation.wait(), done) << validation.err();
    return nlohmann::json::parse(validation.out())["rms_percent"].get<double>();
  };
  EXPECT_LT(rms_percent({}), 0.05);
  EXPECT_GT(rms_percent({"--quasi-static"}), 1.0);
  Process simulation({HYSTCAN_PROGRAM, "simulate", path("found.toml"), "--input", path("record.csv"),
                      "--output", path("moved.csv"), "--dynamics"});
  ASSERT_EQ(simulation.wait(), done) << simulation.err();
  std::istringstream moved(read("moved.csv")), record(read("record.csv"));
  std::string line;
  for (int comment = 0; comment < 2; ++comment) std::getline(record, line);
  double worst = 0.0;
  int row = 0;
  for (std::string given; std::getline(moved, line) && std::getline(record, given); ++row) {
    double x = 0.0, y = 0.0;
    if (row < 100) continue;  // from another memory until the drive has reached both ends
    if (std::sscanf(line.c_str(), "%*f,%*f,%lf", &x) == 1 &&
        std::sscanf(given.c_str(), "%*f,%*f,%lf", &y) == 1)
      worst = std::max(worst, std::abs(x - y));
  }
  EXPECT_LT(worst, 0.06);
  EXPECT_GT(worst, 0.0);
}

TEST_F(Identify, WritesTheCreepThatTwoRatesShow) {
  const model::OutputCreep creep({.per_decade = 0.02});
  for (const auto& [name, steps] : {std::pair{"slow.csv", 600.0}, std::pair{"fast.csv", 60.0}}) {
    Dataset record = piezo_record(steps);
    record.output = with_creep(creep, record.time_s, std::move(record.output));
    write_record(name, record);
  }
  Process program = run({path("slow.csv"), path("fast.csv"), "--order", "3", "--output", path("found.toml"),
                         "--report", path("report")});
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("the output creeps by 2 % of its travel per decade of time"),
            std::string::npos)
      << program.out();
  EXPECT_NE(program.out().find("dataset 2: the other records predict this record with an error of"),
            std::string::npos)
      << program.out();
  EXPECT_NE(read("report/report.html").find("<h2>Selected structure</h2>"), std::string::npos);
  Process judged = validate("fast.csv");
  ASSERT_EQ(judged.wait(), done) << judged.err();
  EXPECT_NE(judged.out().find("includes creep of 2 % per decade from 10 ms to 3 s"), std::string::npos)
      << judged.out();
}

TEST_F(Identify, UsesTheGivenCreep) {
  write_record("loops.csv", piezo_record());
  ASSERT_EQ(identify("loops.csv", {"--creep", "0.01", "--order", "3"}).wait(), done);
  EXPECT_NE(read("found.toml").find("per_decade   = 0.01"), std::string::npos) << read("found.toml");
  for (const char* refused : {"0.2", "-0.01", "much"})
    EXPECT_EQ(identify("loops.csv", {"--creep", refused, "--overwrite"}).wait(), bad_input) << refused;
}

TEST_F(Identify, RefusesADatasetOfAFewRowsAndLeavesNoFolder) {
  write_record("record.csv", piezo_record(10.0));
  write("one.csv", "time_s,input,output\n0,1,2\n");
  write("two.csv", "time_s,input,output\n0,1,2\n1,2,3\n");
  for (const char* few : {"one.csv", "two.csv"})
    for (const bool has_another : {false, true})
      for (const char* option : {"--common-zero", "--dynamics", "--drift"}) {
        std::vector<std::string> more{option, "--order", "2", "--report", path("a/b/report")};
        if (has_another) more.push_back(path("record.csv"));
        Process process = identify(few, more);
        EXPECT_EQ(process.wait(), bad_input) << few << option << process.err();
        EXPECT_NE(process.err().find("expected at least "), std::string::npos) << process.err();
        EXPECT_FALSE(std::filesystem::exists(path("a")));
      }
}

class Validate : public Identify {};

TEST_F(Validate, PrintsTheErrorsOfThePrediction) {
  write_record("record.csv", piezo_record());
  ASSERT_EQ(identify("record.csv", {"--order", "3"}).wait(), done);
  Process program = validate("record.csv");
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("record.csv: predicted with "), std::string::npos) << program.out();
  EXPECT_NE(program.out().find("% at most, relative to the output span "), std::string::npos)
      << program.out();
  Process json = validate("record.csv", {"--json"});
  ASSERT_EQ(json.wait(), done) << json.err();
  EXPECT_LT(nlohmann::json::parse(json.out())["rms_percent"].get<double>(), 0.01);
}

TEST_F(Validate, EstimatesMemoryAndOffsetFromTheFirstSecondsOnly) {
  write_record("record.csv", piezo_record());
  ASSERT_EQ(identify("record.csv", {"--order", "3"}).wait(), done);
  Dataset raised = piezo_record();
  for (double& x : raised.output) x += 2.5;
  write_record("raised.csv", raised);
  Process program =
      validate("raised.csv", {"--estimate-from", "0.2", "--json", "--output", path("predicted.csv")});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto said = nlohmann::json::parse(program.out());
  EXPECT_EQ(said["estimated_from_samples"], 201);
  EXPECT_NEAR(said["offset"].get<double>(), 2.5, 0.01);
  EXPECT_LT(said["rest_rms_percent"].get<double>(), 0.02);
  const std::string csv = read("predicted.csv");
  EXPECT_EQ(csv.substr(0, csv.find('\n')), "time_s,input,output,predicted");
  EXPECT_EQ(outputs_of(csv, 2), raised.output);
  EXPECT_NEAR(rms_between(outputs_of(csv, 3), raised.output) / said["output_span"].get<double>() * 100.0,
              said["rms_percent"].get<double>(), 1e-6);
}

TEST_F(Validate, UsesTheZeroOfTheModelWithNoOffset) {
  write_record("record.csv", piezo_record());
  ASSERT_EQ(identify("record.csv", {"--order", "3"}).wait(), done);
  Dataset raised = piezo_record();
  for (double& x : raised.output) x += 3.0;
  write_record("raised.csv", raised);
  Process program = validate("raised.csv", {"--no-offset", "--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto said = nlohmann::json::parse(program.out());
  EXPECT_EQ(said["offset"], 0.0);
  EXPECT_NEAR(said["rms_percent"].get<double>(), 3.0 * percent_of_stroke, 1.0);
}

TEST_F(Validate, ReportsTheNumberOfSamplesBeyondTheThresholds) {
  write_record("record.csv", piezo_record());
  ASSERT_EQ(identify("record.csv", {"--order", "3", "--thresholds", "observed"}).wait(), done);
  Dataset wider = piezo_record();
  for (double& v : wider.input) v *= 1.1;
  write_record("wider.csv", wider);
  Process program = validate("wider.csv");
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.err().find("samples to the thresholds of the model"), std::string::npos) << program.err();
}

}  // namespace
}  // namespace hystcan::identify_test
