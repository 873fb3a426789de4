// The program from outside: what it prints, writes and returns.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/process.h"
#include "tests/support/shipped.h"

namespace hystcan {
namespace {

using support::Process;

constexpr int done = 0;
constexpr int failed = 1;
constexpr int bad_input = 2;

class Cli : public testing::Test {
 protected:
  std::string path(const char* name) const { return (shipped / name).string(); }
  void write(const char* name, const std::string& text) const { std::ofstream(shipped / name) << text; }
  std::string read(const char* name) const { return support::read_file(shipped / name); }

  support::ShippedCopy shipped;
};

TEST_F(Cli, WithoutASubcommandIsBadUsage) {
  Process program({HYSTCAN_PROGRAM});
  EXPECT_EQ(program.wait(), bad_input);
}

TEST_F(Cli, HelpNamesEverySubcommand) {
  Process program({HYSTCAN_PROGRAM, "--help"});
  EXPECT_EQ(program.wait(), done);
  for (const char* name : {"demo", "controller", "twin", "simulate", "check"})
    EXPECT_NE(program.out().find(name), std::string::npos) << name;
}

TEST_F(Cli, AnUnknownOptionIsBadUsage) {
  Process program({HYSTCAN_PROGRAM, "check", "--frobnicate"});
  EXPECT_EQ(program.wait(), bad_input);
}

TEST_F(Cli, ADurationMustBeATime) {
  for (const char* duration : {"0", "-1", "nan", "inf", "1e300", "soon"}) {
    Process program({HYSTCAN_PROGRAM, "controller", path("piezo.toml"), "--duration", duration});
    EXPECT_EQ(program.wait(), bad_input) << duration;
  }
}

TEST_F(Cli, CheckShowsWhatIsInForce) {
  Process program({HYSTCAN_PROGRAM, "check", path("piezo.toml")});
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("heartbeat_timeout_ms = 300  # default"), std::string::npos);
  EXPECT_NE(program.out().find("previewed by"), std::string::npos);
}

TEST_F(Cli, CheckRefusesAMistakeWithItsPlaceInOneLine) {
  shipped.edit("piezo.toml", "rate_Hz", "rate_hz");
  Process program({HYSTCAN_PROGRAM, "check", path("piezo.toml")});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_EQ(std::ranges::count(program.err(), '\n'), 1);
  EXPECT_NE(program.err().find("piezo.toml:14:1: unknown key rate_hz"), std::string::npos) << program.err();
}

TEST_F(Cli, AnInterfaceThatDoesNotExistFailsAtRunTime) {
  for (const char* command : {"controller", "twin"}) {
    Process program({HYSTCAN_PROGRAM, command, path("piezo.toml"), "--interface", "nocan7"});
    EXPECT_EQ(program.wait(), failed) << command;
    EXPECT_EQ(std::ranges::count(program.err(), '\n'), 1) << program.err();
  }
}

TEST_F(Cli, AnInterfaceThatIsNotCanIsSaidToBeNone) {
  Process program({HYSTCAN_PROGRAM, "twin", path("piezo.toml"), "--interface", "lo"});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("lo is not a CAN interface"), std::string::npos) << program.err();
}

TEST_F(Cli, DemoPrintsFiveColumnsAndWritesPictureAndCsv) {
  Process program(
      {HYSTCAN_PROGRAM, "demo", "--config", path("piezo.toml"), "--output", path("out"), "--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto json = nlohmann::json::parse(program.out());
  EXPECT_EQ(json.at("rate_hz"), 1000.0);
  ASSERT_EQ(json.at("columns").size(), 5u);
  EXPECT_EQ(json.at("columns")[4].at("structure"), "inverse+pi");
  EXPECT_LT(json.at("columns")[4].at("rms_percent"), 0.25);
  EXPECT_GT(json.at("columns")[2].at("rms_percent"), 5.0);
  for (const char* file : {"out/demo.svg", "out/demo.png", "out/inverse+pi.csv"})
    EXPECT_GT(std::filesystem::file_size(shipped / file), 10'000u) << file;
}

TEST_F(Cli, DemoRunsTheGalfenolStageToo) {
  Process program({HYSTCAN_PROGRAM, "demo", "--config", path("galfenol.toml"), "--output", path("out")});
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("inverse+pi"), std::string::npos);
}

TEST_F(Cli, SimulateThereAndBackAgainIsTheIdentity) {
  std::string text = "time_s,input\n";
  for (int i = 0; i < 500; ++i)
    text += std::to_string(i * 1e-3) + "," +
            std::to_string(50 + 49 * std::sin(0.05 * i) * std::cos(0.002 * i)) + "\n";
  write("in.csv", text);
  Process forward({HYSTCAN_PROGRAM, "simulate", path("piezo.model.toml"), "--input", path("in.csv"),
                   "--output", path("there.csv")});
  ASSERT_EQ(forward.wait(), done) << forward.err();
  Process inverse({HYSTCAN_PROGRAM, "simulate", path("piezo.model.toml"), "--input", path("there.csv"),
                   "--output", path("back.csv"), "--inverse"});
  ASSERT_EQ(inverse.wait(), done) << inverse.err();

  std::istringstream there(read("there.csv"));
  std::istringstream back(read("back.csv"));
  std::string a;
  std::string b;
  int rows = -1;
  while (std::getline(there, a) && std::getline(back, b)) {
    if (++rows == 0) continue;
    double ta, va, xa, tb, vb, xb;
    ASSERT_EQ(std::sscanf(a.c_str(), "%lf,%lf,%lf", &ta, &va, &xa), 3) << a;
    ASSERT_EQ(std::sscanf(b.c_str(), "%lf,%lf,%lf", &tb, &vb, &xb), 3) << b;
    EXPECT_EQ(ta, tb);
    EXPECT_NEAR(va, vb, 1e-9);
    EXPECT_NEAR(xa, xb, 1e-11);
  }
  EXPECT_EQ(rows, 500);
}

TEST_F(Cli, SimulateRefusesACsvWithAHoleAndLeavesTheOldOutputAlone) {
  write("in.csv", "time_s,input\n0,1\n1,\n");
  write("out.csv", "precious");
  Process program({HYSTCAN_PROGRAM, "simulate", path("piezo.model.toml"), "--input", path("in.csv"),
                   "--output", path("out.csv")});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("in.csv:3:3: input is empty, expected a number"), std::string::npos)
      << program.err();
  EXPECT_EQ(read("out.csv"), "precious");
  EXPECT_FALSE(std::filesystem::exists(shipped / "out.csv.part"));
}

TEST_F(Cli, SimulateSaysWhereTheDiskIsFullOrTheFolderMissing) {
  write("in.csv", "time_s,input\n0,1\n");
  Process program({HYSTCAN_PROGRAM, "simulate", path("piezo.model.toml"), "--input", path("in.csv"),
                   "--output", path("no/such/folder.csv")});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("cannot be written: No such file or directory"), std::string::npos)
      << program.err();
}

TEST_F(Cli, SimulateNeverOverwritesWhatItReads) {
  write("in.csv", "input\n1\n");
  for (const char* output : {"in.csv", "piezo.model.toml"}) {
    const std::string before = read(output);
    Process program({HYSTCAN_PROGRAM, "simulate", path("piezo.model.toml"), "--input", path("in.csv"),
                     "--output", path(output)});
    EXPECT_EQ(program.wait(), bad_input) << output;
    EXPECT_EQ(read(output), before);
  }
}

TEST_F(Cli, SimulateWritesToADeviceAsItIs) {
  std::filesystem::create_symlink("/dev/full", shipped / "full.csv");
  write("in.csv", "input\n1\n");
  Process program({HYSTCAN_PROGRAM, "simulate", path("piezo.model.toml"), "--input", path("in.csv"),
                   "--output", path("full.csv")});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("No space left on device"), std::string::npos) << program.err();
  EXPECT_TRUE(std::filesystem::is_symlink(shipped / "full.csv"));
}

TEST_F(Cli, ControllerLeavesFilesAloneUntilTheBusIsOpen) {
  const std::string before = read("piezo.toml");
  Process onto_itself({HYSTCAN_PROGRAM, "controller", path("piezo.toml"), "--csv", path("piezo.toml")});
  EXPECT_EQ(onto_itself.wait(), bad_input);
  EXPECT_EQ(read("piezo.toml"), before);
  write("run.csv", "precious");
  Process no_bus(
      {HYSTCAN_PROGRAM, "controller", path("piezo.toml"), "--interface", "nocan7", "--csv", path("run.csv")});
  EXPECT_EQ(no_bus.wait(), failed);
  EXPECT_EQ(read("run.csv"), "precious");
}

TEST_F(Cli, DemoFailsWhereAnAxisNeverTracks) {
  shipped.edit("piezo.toml", "wipe_slew_V_per_s  = 500.0 ", "wipe_slew_V_per_s  = 1e-3 ");
  Process program({HYSTCAN_PROGRAM, "demo", "--config", path("piezo.toml"), "--output", path("out")});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("axis x did not come to track"), std::string::npos) << program.err();
}

TEST_F(Cli, SimulateRefusesAModelThatCannotBeInverted) {
  shipped.edit("piezo.model.toml", "k_ascending  = 0.035", "k_ascending  = 1.0");
  write("in.csv", "input\n1\n");
  Process program({HYSTCAN_PROGRAM, "simulate", path("piezo.model.toml"), "--input", path("in.csv"),
                   "--output", path("out.csv")});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("k_ascending"), std::string::npos) << program.err();
}

}  // namespace
}  // namespace hystcan
