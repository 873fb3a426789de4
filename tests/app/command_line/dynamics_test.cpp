// `hystcan dynamics` as a process.
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <sstream>
#include <vector>

#include "tests/app/command_line/cli.h"

namespace hystcan::dynamics_test {
namespace {

constexpr double pi = std::numbers::pi;

class Dynamics : public Cli {
 protected:
  Process run(const char* data, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{HYSTCAN_PROGRAM, "dynamics", path(data), "--output",
                                   path("fragment.toml")};
    words.insert(words.end(), more.begin(), more.end());
    return Process(words);
  }
  /// Steps of 2 V up and down around 50 V every 0.1 s at 1 kHz; a mode of 180 Hz and 0.06 with a delay of
  /// 0.4 ms.
  void write_steps(const char* name, double noise_um, double move_V = 2.0) const {
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
        position += (step % 200 == 0 ? -1.0 : 1.0) * move_V * response((n - step) * 1e-3 - 0.4e-3);
      const double drive = 50.0 + (n >= 100 && (n / 100) % 2 == 1 ? move_V : 0.0);
      out << n * 1e-3 << ',' << drive << ',' << 15.0 + 0.3 * position + noise(random) << '\n';
    }
  }
};

TEST_F(Dynamics, FindsTheModeAndWritesAFragment) {
  write_steps("steps.csv", 0.002);
  Process program = run("steps.csv", {"--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto found = nlohmann::json::parse(program.out());
  const auto holds = [&](const char* name, double value) {
    EXPECT_LE(std::abs(found[name]["value"].get<double>() - value),
              3.0 * found[name]["standard_error"].get<double>())
        << name << ' ' << found[name];
  };
  holds("natural_frequency_Hz", 180.0);
  holds("damping_ratio", 0.06);
  holds("delay_s", 0.4e-3);
  holds("gain", 0.3);
  EXPECT_LT(found["worst_margins"]["peak_sensitivity"], 1.72);
  EXPECT_TRUE(found["worst_margins"]["stable"]);

  const std::string fragment = read("fragment.toml");
  std::ostringstream ki;
  ki << "ki_per_s               = " << found["ki_per_s"].get<double>();
  for (const std::string& expected :
       {std::string("[axis.control]\nkp                     = "), ki.str(),
        std::string("[axis.control.delays]\ncommand_delay_us"), std::string("\namplifier_bandwidth_Hz = "),
        std::string("\nresonance_Hz           = 1"), std::string("\ndamping_ratio          = 0.0"),
        std::string("# natural frequency  1")})
    EXPECT_NE(fragment.find(expected), std::string::npos) << expected << "\n" << fragment;
}

TEST_F(Dynamics, KeepsTheMarginsOfTheCautiousRuleOnRequest) {
  write_steps("steps.csv", 0.002);
  Process program = run("steps.csv", {"--json", "--cautious"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto found = nlohmann::json::parse(program.out());
  EXPECT_GE(found["margins"]["phase_margin_deg"], 59.5);
  EXPECT_GE(found["margins"]["gain_margin_dB"], 6.0);
  EXPECT_TRUE(found["notch"].is_null());
}

// The steps have a pure delay of 0.4 ms and no lag.
TEST_F(Dynamics, SaysThatAPureDelayIsNoLag) {
  write_steps("steps.csv", 0.002);
  Process program = run("steps.csv");
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("no lag but a pure delay, counted as the sensor's"), std::string::npos)
      << program.out();
  Process as_json = run("steps.csv", {"--json"});
  ASSERT_EQ(as_json.wait(), done) << as_json.err();
  EXPECT_NEAR(nlohmann::json::parse(as_json.out())["sensor_delay_us"].get<double>(), 400.0, 20.0);
}

// Half of it is stated to be the sensor's. A lag that looks like the rest in the record is a little longer.
TEST_F(Dynamics, AttributesWhatIsNotTheConfiguredSensorsToTheAmplifier) {
  write_steps("steps.csv", 0.002);
  shipped.edit("piezo.toml", "[axis.control.delays]\n", "[axis.control.delays]\nsensor_delay_us = 200.0\n");
  Process program = run("steps.csv", {"--json", "--config", path("piezo.toml")});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto found = nlohmann::json::parse(program.out());
  EXPECT_EQ(found["sensor_delay_us"], 200.0);
  EXPECT_NEAR(1.0 / (2.0 * pi * found["amplifier_bandwidth_Hz"].get<double>()), 0.2e-3, 0.04e-3);
}

TEST_F(Dynamics, AcceptsRowsThatAreLeftOut) {
  write_steps("steps.csv", 0.002);
  std::istringstream all(read("steps.csv"));
  std::ofstream some(shipped / "some.csv");
  int row = 0;
  for (std::string line; std::getline(all, line); ++row)
    if (row < 10 || row % 97 != 0) some << line << '\n';
  some.close();
  Process program = run("some.csv", {"--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto found = nlohmann::json::parse(program.out());
  EXPECT_EQ(found["left_out"], 8);
  EXPECT_NEAR(found["natural_frequency_Hz"]["value"], 180.0, 0.5);
}

TEST_F(Dynamics, PrintsTheIntervalsTheRuleAndTheMargins) {
  write_steps("steps.csv", 0.002);
  Process program = run("steps.csv", {"--rate", "2000"});
  ASSERT_EQ(program.wait(), done) << program.err();
  for (const char* expected :
       {"natural frequency", "Hz (95 %:", "um per V", "phase margin", "at 2000 Hz", "rule"})
    EXPECT_NE(program.out().find(expected), std::string::npos) << expected << "\n" << program.out();
}

TEST_F(Dynamics, WritesTheResultIntoACopyOfAConfiguration) {
  write_steps("steps.csv", 0.002);
  Process program = run(
      "steps.csv", {"--config", path("piezo.toml"), "--axis", "y", "--write", path("new.toml"), "--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto found = nlohmann::json::parse(program.out());
  EXPECT_EQ(found["rate_Hz"], 1000.0);
  const std::string text = read("new.toml");
  std::ostringstream ki;
  ki << "ki_per_s           = " << found["ki_per_s"].get<double>();
  EXPECT_NE(text.find(ki.str(), text.find("name           = \"y\"")), std::string::npos) << text;
  Process check({HYSTCAN_PROGRAM, "check", path("new.toml")});
  EXPECT_EQ(check.wait(), done) << check.err();
}

TEST_F(Dynamics, RefusesToWriteWithoutAConfigurationOrIntoItsInputs) {
  write_steps("steps.csv", 0.002);
  Process none = run("steps.csv", {"--write", path("new.toml")});
  EXPECT_EQ(none.wait(), bad_input);
  EXPECT_NE(none.err().find("--write requires --config"), std::string::npos) << none.err();
  for (const char* input : {"piezo.toml", "piezo.model.toml", "steps.csv", "fragment.toml"}) {
    Process program = run("steps.csv", {"--config", path("piezo.toml"), "--write", path(input)});
    EXPECT_EQ(program.wait(), bad_input) << input;
  }
}

TEST_F(Dynamics, RefusesADatasetWithoutInformationAndWritesNothing) {
  write_steps("flat.csv", 0.002, 0.0);
  Process program = run("flat.csv");
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("flat.csv: input is constant, expected a step or a chirp"), std::string::npos)
      << program.err();
  EXPECT_FALSE(std::filesystem::exists(shipped / "fragment.toml"));
}

TEST_F(Dynamics, RefusesAnInvalidRateAndAnOutputThatIsItsInput) {
  write_steps("fragment.toml", 0.002);
  Process overwriting = run("fragment.toml");
  EXPECT_EQ(overwriting.wait(), bad_input);
  write_steps("steps.csv", 0.002);
  Process program = run("steps.csv", {"--rate", "0"});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("--rate: 0, expected a finite number > 0"), std::string::npos)
      << program.err();
}

}  // namespace
}  // namespace hystcan::dynamics_test
