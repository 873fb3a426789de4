// `hystcan simulate` with a model file that has [creep], as a process.
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>
#include <vector>

#include "model/output_creep.h"
#include "tests/app/command_line/cli.h"
#include "tests/app/command_line/model_kinds.h"
#include "tests/app/command_line/rows.h"

namespace hystcan::simulate_creep_test {
namespace {

#define HYSTCAN_CREEP "\n[creep]\nper_decade = 0.023\nfrom_s = 0.01\nto_s = 3.0\n"

constexpr const char* recursive_memory =
    "[hysteresis]\nkind = \"recursive-memory\"\n" HYSTCAN_UNITS HYSTCAN_CURVES
    "k_ascending = 0.05\nk_descending = 0.04\n";

class SimulateCreep : public Cli {
 protected:
  SimulateCreep() { write("stage.toml", recursive_memory + std::string(HYSTCAN_CREEP)); }

  Process run(const char* input, const char* output, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{HYSTCAN_PROGRAM, "simulate", path("stage.toml"), "--input",
                                   path(input),     "--output", path(output)};
    words.insert(words.end(), more.begin(), more.end());
    return Process(words);
  }
  void expect_done(const char* input, const char* output, const std::vector<std::string>& more = {}) const {
    Process program = run(input, output, more);
    ASSERT_EQ(program.wait(), done) << program.err();
  }
  void expect_refused(const char* input, const std::vector<std::string>& more, const char* message) const {
    Process program = run(input, "refused.csv", more);
    EXPECT_EQ(program.wait(), bad_input);
    EXPECT_NE(program.err().find(message), std::string::npos) << program.err();
    EXPECT_FALSE(std::filesystem::exists(shipped / "refused.csv"));
  }
  /// A decaying oscillation with rows at uneven times; the longest interval is 2 s.
  void write_record(const char* name, int rows) const {
    std::ofstream out(shipped / name);
    out.precision(17);
    out << "time_s,input\n";
    double time_s = 0.25;
    for (int i = 0; i < rows; ++i) {
      out << time_s << ',' << 50 + 49 * std::sin(0.05 * i) * std::cos(2.0 * i / rows) << '\n';
      time_s += i % 50 == 0 ? 2.0 : 1e-3 * (1 + i % 7);
    }
  }
};

class CreepOfEveryKind : public SimulateCreep, public testing::WithParamInterface<Kind> {
 protected:
  CreepOfEveryKind() { write("stage.toml", GetParam().model + std::string(HYSTCAN_CREEP)); }
};

INSTANTIATE_TEST_SUITE_P(Of, CreepOfEveryKind, testing::ValuesIn(every_kind(recursive_memory)),
                         [](const auto& test) { return test.param.name; });

TEST_P(CreepOfEveryKind, ContinuesFromASavedMemoryAsInOneRun) {
  write_record("in.csv", 400);
  const std::string record = read("in.csv"), header = "time_s,input\n";
  for (const int rows : {51, 250}) {  // 51: the next row is 2 s later
    std::size_t cut = 0;
    for (int i = 0; i < 1 + rows; ++i) cut = record.find('\n', cut) + 1;
    write("first.csv", record.substr(0, cut));
    write("second.csv", header + record.substr(cut));
    expect_done("in.csv", "whole.csv", {"--overwrite"});
    expect_done("first.csv", "a.csv", {"--save-memory", path("memory.toml"), "--overwrite"});
    expect_done("second.csv", "b.csv", {"--memory", path("memory.toml"), "--overwrite"});
    const std::string b = read("b.csv");
    EXPECT_EQ(read("whole.csv"), read("a.csv") + b.substr(b.find('\n') + 1)) << rows;
  }
}

TEST_F(SimulateCreep, IsReportedAndQuasiStaticIgnoresTheTable) {
  write("plain.toml", recursive_memory);
  write_record("in.csv", 100);
  Process with = run("in.csv", "with.csv");
  ASSERT_EQ(with.wait(), done) << with.err();
  EXPECT_NE(with.err().find("include creep of 2.3 % per decade from 10 ms to 3 s of the model file"),
            std::string::npos)
      << with.err();
  expect_done("in.csv", "without.csv", {"--quasi-static"});
  Process plain({HYSTCAN_PROGRAM, "simulate", path("plain.toml"), "--input", path("in.csv"), "--output",
                 path("plain.csv")});
  ASSERT_EQ(plain.wait(), done) << plain.err();
  EXPECT_EQ(plain.err().find("creep"), std::string::npos) << plain.err();
  EXPECT_EQ(read("without.csv"), read("plain.csv"));
  EXPECT_NE(read("with.csv"), read("plain.csv"));
}

TEST_F(SimulateCreep, IsAppliedBeforeTheMode) {
  std::ofstream(shipped / "stage.toml", std::ios::app)
      << "\n[dynamics]\nresonance_Hz = 2000.0\ndamping_ratio = 1.0\ndelay_s = 0.0\n";
  std::string text = "time_s,input\n";
  for (int i = 0; i < 200; ++i) text += std::to_string(0.01 * i) + (i < 100 ? ",0\n" : ",80\n");
  write("in.csv", text);
  expect_done("in.csv", "crept.csv");
  expect_done("in.csv", "moved.csv", {"--dynamics"});
  // 10 ms are 20 periods of the mode: each row equals the creeping output of the previous row.
  const auto crept = rows_of(read("crept.csv")), moved = rows_of(read("moved.csv"));
  for (std::size_t i = 1; i < 200; ++i) EXPECT_NEAR(moved[i].output, crept[i - 1].output, 1e-6) << i;
}

TEST_F(SimulateCreep, NeedsTimesThatIncrease) {
  write("untimed.csv", "input\n0\n1\n");
  expect_refused("untimed.csv", {}, "untimed.csv: has no column time_s, expected this column, because ");
  expect_done("untimed.csv", "out.csv", {"--quasi-static"});
  write("twice.csv", "time_s,input\n0,0\n0.5,1\n0.5,2\n");
  expect_refused("twice.csv", {}, "twice.csv: row 3 is at 0.5 s, expected more than 0.5 s");
}

TEST_F(SimulateCreep, RefusesAFileThatBeginsBeforeItsMemory) {
  write("in.csv", "time_s,input\n0,0\n3,80\n");
  expect_done("in.csv", "out.csv", {"--save-memory", path("memory.toml")});
  expect_refused("in.csv", {"--memory", path("memory.toml")},
                 "in.csv: the first row is at 0 s, expected more than 3 s, which is time_s of ");
  std::string memory = read("memory.toml");
  memory.erase(memory.find("time_s"));
  write("memory.toml", memory);
  write("next.csv", "time_s,input\n0,80\n");
  expect_done("next.csv", "next_out.csv", {"--memory", path("memory.toml")});
  EXPECT_EQ(rows_of(read("next_out.csv"))[0].output, rows_of(read("out.csv"))[1].output);
}

TEST_F(SimulateCreep, BeginsSettledIfTheMemoryHasNoCreep) {
  write("memory.toml",
        "[memory]\nkind = \"recursive-memory\"\norigin = \"lower-threshold\"\n"
        "turning_inputs = [80, 20]\ninput = 40\n");
  write("in.csv", "time_s,input\n0,50\n100,50\n");
  expect_done("in.csv", "out.csv", {"--memory", path("memory.toml")});
  const auto rows = rows_of(read("out.csv"));
  EXPECT_DOUBLE_EQ(rows[0].output, rows[1].output);
}

struct BadCreep {
  const char* name;
  const char* lines;
  const char* message;  ///< with its place

  friend void PrintTo(const BadCreep& creep, std::ostream* out) { *out << creep.name; }
};
class BadCreeps : public SimulateCreep, public testing::WithParamInterface<BadCreep> {};

TEST_P(BadCreeps, AreRefusedAtTheirPlace) {
  write("memory.toml", "[memory]\nkind = \"recursive-memory\"\norigin = \"virgin\"\ninput = 3\n" +
                           std::string(GetParam().lines));
  write("in.csv", "time_s,input\n0,50\n");
  expect_refused("in.csv", {"--memory", path("memory.toml")}, GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Of, BadCreeps,
    testing::Values(
        BadCreep{"TooFew", "creep = [1, 2, 3]\n",
                 "memory.toml:5:9: creep has 3 values, expected 6, one for each lag in the model's [creep]"},
        BadCreep{"None", "creep = []\n", "memory.toml:5:9: creep has 0 values, expected 6"},
        BadCreep{"NotFinite", "creep = [1, 2, nan, 4, 5, 6]\n", "memory.toml:5:16: creep is nan"},
        BadCreep{"TimeNotFinite", "creep = [1, 2, 3, 4, 5, 6]\ntime_s = inf\n",
                 "memory.toml:6:10: time_s is inf"},
        BadCreep{"TimeAlone", "time_s = 4\n",
                 "memory.toml:5:10: time_s is present without creep, expected both keys"}),
    [](const auto& test) { return test.param.name; });

TEST_F(SimulateCreep, InAMemoryIsRefusedByAModelWithoutCreep) {
  write("in.csv", "time_s,input\n0,0\n3,80\n");
  expect_done("in.csv", "out.csv", {"--save-memory", path("memory.toml")});
  write("stage.toml", recursive_memory);
  write("next.csv", "time_s,input\n4,80\n");
  expect_refused("next.csv", {"--memory", path("memory.toml")},
                 ":12:9: creep is not allowed in the memory of a model without [creep]");
  expect_done("next.csv", "next_out.csv", {"--memory", path("memory.toml"), "--quasi-static"});
}

class ValidateCreep : public SimulateCreep {
 protected:
  ValidateCreep() {
    write_record("in.csv", 400);
    expect_done("in.csv", "record.csv", {"--save-memory", path("memory.toml")});
  }
  Process validate(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{HYSTCAN_PROGRAM, "validate", path("stage.toml"), path("record.csv")};
    words.insert(words.end(), more.begin(), more.end());
    return Process(words);
  }
  nlohmann::json json_of(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"--json"};
    words.insert(words.end(), more.begin(), more.end());
    Process program = validate(words);
    EXPECT_EQ(program.wait(), done) << program.err();
    return nlohmann::json::parse(program.out());
  }
};

TEST_F(ValidateCreep, IsUsedAndReported) {
  Process said = validate();
  ASSERT_EQ(said.wait(), done) << said.err();
  EXPECT_NE(said.out().find(
                "\nthe prediction includes creep of 2.3 % per decade from 10 ms to 3 s of the model file\n"),
            std::string::npos)
      << said.out();
  const nlohmann::json json = json_of();
  EXPECT_LT(json["rms_percent"].get<double>(), 1e-6);
  EXPECT_EQ(json["creep"], (nlohmann::json{{"per_decade", 0.023}, {"from_s", 0.01}, {"to_s", 3.0}}));
}

TEST_F(ValidateCreep, IsIgnoredIfQuasiStatic) {
  Process said = validate({"--quasi-static"});
  ASSERT_EQ(said.wait(), done) << said.err();
  EXPECT_EQ(said.out().find("creep"), std::string::npos) << said.out();
  const nlohmann::json json = json_of({"--quasi-static"});
  EXPECT_GT(json["rms_percent"].get<double>(), 0.5);
  EXPECT_TRUE(json["creep"].is_null());
}

TEST_F(ValidateCreep, BeginsWithTheCreepOfTheMemory) {
  write("first.csv", "time_s,input\n0,0\n3,80\n3.01,20\n");
  expect_done("first.csv", "first_out.csv", {"--save-memory", path("moved.toml")});
  std::string memory = read("moved.toml");
  memory.erase(memory.find("time_s"));  // the creep is then that of the next row, as in validate
  write("at_first_row.toml", memory);
  expect_done("in.csv", "record.csv", {"--memory", path("at_first_row.toml"), "--overwrite"});
  EXPECT_LT(json_of({"--memory", path("moved.toml")})["max_percent"].get<double>(), 1e-9);
}

}  // namespace
}  // namespace hystcan::simulate_creep_test
