// `hystcan tune --record`: the dynamics from a record of small steps, and its refusals.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <regex>
#include <sstream>
#include <vector>

#include "tests/app/command_line/cli.h"

namespace hystcan::tune_record_test {
namespace {

using nlohmann::json;

constexpr double pi = std::numbers::pi;

/// A record of a stage whose mode differs from the configured one.
class TuneRecord : public Cli {
 protected:
  void SetUp() override { write_steps("steps.csv", 0.002); }
  Process run(const char* data, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{HYSTCAN_PROGRAM, "tune",     path("piezo.toml"),   "--record",
                                   path(data),      "--output", path("fragment.toml")};
    words.insert(words.end(), more.begin(), more.end());
    return Process(words);
  }
  json found_in(const char* data, std::vector<std::string> more = {}) const {
    more.emplace_back("--json");
    Process program = run(data, more);
    EXPECT_EQ(program.wait(), done) << program.err();
    return json::parse(program.out());
  }
  void expect_refused(Process program, const std::string& words) const {
    EXPECT_EQ(program.wait(), bad_input) << words;
    EXPECT_NE(program.err().find(words), std::string::npos) << program.err();
    EXPECT_FALSE(std::filesystem::exists(shipped / "fragment.toml"));
  }
  /// Steps of 2 V up and down around 50 V every 100 rows; a mode of 180 Hz and 0.06 with a delay of 0.4 ms.
  void write_steps(const char* name, double noise_um, double move_V = 2.0, double rate_Hz = 1000.0) const {
    std::mt19937_64 random(11);
    std::normal_distribution<double> noise(0.0, noise_um);
    const double omega = 2.0 * pi * 180.0, zeta = 0.06, root = std::sqrt(1.0 - zeta * zeta);
    const auto response = [&](double t) {
      if (t <= 0.0) return 0.0;
      const double w = omega * root;
      return 1.0 - std::exp(-zeta * omega * t) * (std::cos(w * t) + zeta / root * std::sin(w * t));
    };
    std::ofstream out(shipped / name);
    out.precision(17);
    out << "# input_unit = V\n# output_unit = um\ntime_s,input,output\n";
    for (int n = 0; n < 800; ++n) {
      double position = 0.0;
      for (int step = 100; step < n; step += 100)
        position += (step % 200 == 0 ? -1.0 : 1.0) * move_V * response((n - step) / rate_Hz - 0.4e-3);
      const double drive = 50.0 + (n >= 100 && (n / 100) % 2 == 1 ? move_V : 0.0);
      out << n / rate_Hz << ',' << drive << ',' << 15.0 + 0.3 * position + noise(random) << '\n';
    }
  }
};

TEST_F(TuneRecord, FindsTheModeAndWritesAFragment) {
  const json found = found_in("steps.csv");
  const auto holds = [&](const char* name, double value) {
    EXPECT_LE(std::abs(found[name]["value"].get<double>() - value),
              3.0 * found[name]["standard_error"].get<double>())
        << name << ' ' << found[name];
  };
  holds("natural_frequency_Hz", 180.0);
  holds("damping_ratio", 0.06);
  holds("delay_s", 0.4e-3);
  holds("gain", 0.3);
  EXPECT_EQ(found["record"], "steps.csv");
  EXPECT_LT(found["proposed"]["worst_margins"]["peak_sensitivity"], 1.72);
  const std::string fragment = read("fragment.toml");
  for (const char* expected :
       {"[axis.control]\nkp                     = ", "[axis.control.delays]\n",
        "\nresonance_Hz           = 1", "\ndamping_ratio          = 0.0", "# natural frequency  1",
        "# dataset            steps.csv: 800 rows at 1000 Hz"})
    EXPECT_NE(fragment.find(expected), std::string::npos) << expected << "\n" << fragment;
}

TEST_F(TuneRecord, MayHaveTheOutputInAnotherFile) {
  std::istringstream rows(read("steps.csv"));
  std::ofstream drive(shipped / "drive.csv"), position(shipped / "position.csv");
  std::smatch row;
  for (std::string line; std::getline(rows, line);)
    if (std::regex_match(line, row, std::regex("([0-9.e-]+),([^,]+),([^,]+)"))) {
      drive << row[1] << ',' << row[2] << '\n';
      position << row[1] << ',' << row[3] << '\n';
    }
  drive.close();
  position.close();
  const json together = found_in("steps.csv");
  const json apart = found_in("drive.csv", {"--output-from", path("position.csv")});
  EXPECT_EQ(apart["natural_frequency_Hz"], together["natural_frequency_Hz"]);
}

TEST_F(TuneRecord, ProposesTheSameAsAnExperimentWithTheseSteps) {
  Process excite({HYSTCAN_PROGRAM, "excite", path("piezo.toml"), "--rehearse", "--signal", "step",
                  "--amplitude", "1", "--output", path("excited.csv")});
  ASSERT_EQ(excite.wait(), done) << excite.err();
  Process experiment(
      {HYSTCAN_PROGRAM, "tune", path("piezo.toml"), "--rehearse", "--json", "--output", path("tuning.toml")});
  ASSERT_EQ(experiment.wait(), done) << experiment.err();
  const json driven = json::parse(experiment.out()), found = found_in("excited.csv");
  for (const char* figure : {"natural_frequency_Hz", "damping_ratio", "delay_s", "gain", "proposed"})
    EXPECT_EQ(found[figure], driven[figure]) << figure;
}

// The steps have a pure delay of 0.4 ms and no lag.
TEST_F(TuneRecord, AttributesAPureDelayToTheSensor) {
  Process program = run("steps.csv");
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("of pure delay, attributed to the sensor"), std::string::npos)
      << program.out();
}

// Half of the delay is stated as the sensor's. A lag that resembles the rest in the record is slightly
// longer.
TEST_F(TuneRecord, AttributesTheRestOfTheDelayToTheAmplifier) {
  shipped.edit("piezo.toml", "[axis.control.delays]\n", "[axis.control.delays]\nsensor_delay_us = 200.0\n");
  const json delays = found_in("steps.csv", {"--cautious"})["candidates"].back()["delays"];
  EXPECT_EQ(delays["sensor_delay_us"], 200.0);
  EXPECT_NEAR(1.0 / (2.0 * pi * delays["amplifier_bandwidth_Hz"].get<double>()), 0.2e-3, 0.04e-3);
}

TEST_F(TuneRecord, AcceptsMissingRows) {
  std::istringstream all(read("steps.csv"));
  std::ofstream some(shipped / "some.csv");
  int row = 0;
  for (std::string line; std::getline(all, line); ++row)
    if (row < 10 || row % 97 != 0) some << line << '\n';
  some.close();
  const json found = found_in("some.csv");
  EXPECT_EQ(found["left_out"], 8);
  EXPECT_NEAR(found["natural_frequency_Hz"]["value"], 180.0, 0.5);
}

// Far below the mode, the present loop is an integrator, ki / s, at any rate of the record.
TEST_F(TuneRecord, TabulatesTheLoopAtTheRateOfTheCycles) {
  write_steps("fast.csv", 0.002, 2.0, 2000.0);
  const double ki_per_s = found_in("fast.csv", {"--response", path("r.csv")})["present"]["ki_per_s"];
  std::istringstream rows(read("r.csv"));
  std::string row;
  double frequency_Hz = 0.0;
  while (frequency_Hz < 15.0 && std::getline(rows, row)) frequency_Hz = std::strtod(row.c_str(), nullptr);
  ASSERT_LT(frequency_Hz, 30.0);
  std::string before_gain;
  std::istringstream cells(row);
  for (int column = 0; column < 7; ++column) std::getline(cells, before_gain, ',');
  EXPECT_NEAR(std::stod(before_gain) * 2.0 * pi * frequency_Hz / ki_per_s, 1.0, 0.05);
}

TEST_F(TuneRecord, RefusesARecordWithoutInformationAndWritesNothing) {
  write_steps("flat.csv", 0.002, 0.0);
  expect_refused(run("flat.csv"), "flat.csv: input is constant, expected a step or a chirp");
}

TEST_F(TuneRecord, RefusesARecordInAnotherUnitThanTheDrives) {
  write("ampere.csv", std::regex_replace(read("steps.csv"), std::regex("input_unit = V"), "input_unit = A"));
  expect_refused(run("ampere.csv"), "ampere.csv: the file has input_unit = \"A\", expected \"V\"");
}

TEST_F(TuneRecord, RefusesTheOptionsOfAnExperiment) {
  for (const char* option : {"--rehearse", "--clear-faults"})
    expect_refused(run("steps.csv", {option}), std::string("--record excludes ") + option);
  for (const char* option : {"--amplitude", "--centre", "--period", "--cycles"})
    expect_refused(run("steps.csv", {option, "1"}), std::string("--record excludes ") + option);
}

}  // namespace
}  // namespace hystcan::tune_record_test
