// `hystcan simulate` as a process.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <ostream>
#include <vector>

#include "tests/app/command_line/cli.h"
#include "tests/app/command_line/model_kinds.h"
#include "tests/app/command_line/rows.h"

namespace hystcan::simulate_test {
namespace {

class Simulate : public Cli {
 protected:
  std::vector<std::string> command(const char* model, const char* input, const char* output,
                                   const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{HYSTCAN_PROGRAM, "simulate", path(model), "--input",
                                   path(input),     "--output", path(output)};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  Process run(const char* model, const char* input, const char* output,
              const std::vector<std::string>& more = {}) const {
    return Process(command(model, input, output, more));
  }
  /// Writes `rows` rows of a decaying oscillation between `lo` and `hi`.
  void write_record(const char* name, int rows, double lo = 0.0, double hi = 100.0) const {
    std::ofstream out(shipped / name);
    out.precision(17);
    out << "time_s,input\n";
    for (int i = 0; i < rows; ++i)
      out << i * 1e-3 << ','
          << (lo + hi) / 2 + 0.49 * (hi - lo) * std::sin(0.05 * i) * std::cos(2.0 * i / rows) << '\n';
  }
};

class EveryKind : public Simulate, public testing::WithParamInterface<Kind> {};

TEST_P(EveryKind, InverseThenForwardReturnsTheOutput) {
  const Kind& kind = GetParam();
  if (*kind.model != '\0')  // "": the shipped piezo model
    write("piezo.model.toml", kind.model);
  write_record("in.csv", 500);
  Process forward = run("piezo.model.toml", "in.csv", "there.csv");
  ASSERT_EQ(forward.wait(), done) << forward.err();
  Process inverse = run("piezo.model.toml", "there.csv", "back.csv", {"--inverse"});
  ASSERT_EQ(inverse.wait(), done) << inverse.err();
  const std::vector<Row> there = rows_of(read("there.csv")), back = rows_of(read("back.csv"));
  ASSERT_EQ(there.size(), 500u);
  ASSERT_EQ(back.size(), 500u);
  for (std::size_t i = 0; i < 500; ++i) {
    EXPECT_EQ(there[i].time_s, back[i].time_s);
    EXPECT_NEAR(there[i].input, back[i].input, kind.input_tolerance) << i;
    EXPECT_NEAR(there[i].output, back[i].output, 1e-11) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, EveryKind, testing::ValuesIn(every_kind("")),
                         [](const auto& test) { return test.param.name; });

TEST_F(Simulate, RefusesACsvWithAnEmptyFieldAndKeepsTheOldOutput) {
  write("in.csv", "time_s,input\n0,1\n1,\n");
  write("out.csv", "precious");
  Process program = run("piezo.model.toml", "in.csv", "out.csv", {"--overwrite"});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("in.csv:3:3: input is empty, expected a number"), std::string::npos)
      << program.err();
  EXPECT_EQ(read("out.csv"), "precious");
  EXPECT_FALSE(std::filesystem::exists(shipped / "out.csv.part"));
}

TEST_F(Simulate, RefusesToOverwriteAnOutput) {
  write("in.csv", "time_s,input\n0,1\n");
  write("out.csv", "precious");
  EXPECT_EQ(run("piezo.model.toml", "in.csv", "out.csv").wait(), bad_input);
  EXPECT_EQ(read("out.csv"), "precious");
}

TEST_F(Simulate, RefusesADatasetInAnotherUnitThanTheModel) {
  write("in.csv", "# input_unit = \"A\"\ntime_s,input\n0,1\n");
  Process program = run("piezo.model.toml", "in.csv", "out.csv");
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("in.csv: the file has input_unit = \"A\", expected \"V\""), std::string::npos)
      << program.err();
}

TEST_F(Simulate, WritesDirectlyToADevice) {
  std::filesystem::create_symlink("/dev/full", shipped / "full.csv");
  write("in.csv", "input\n1\n");
  Process program = run("piezo.model.toml", "in.csv", "full.csv");
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("No space left on device"), std::string::npos) << program.err();
  EXPECT_TRUE(std::filesystem::is_symlink(shipped / "full.csv"));
}

struct BadMemory {
  const char* name;
  const char* text;
  const char* message;  ///< with its place

  friend void PrintTo(const BadMemory& memory, std::ostream* out) { *out << memory.name; }
};

class BadMemories : public Simulate, public testing::WithParamInterface<BadMemory> {};

TEST_P(BadMemories, AreRefusedAtTheirPlaceAndWriteNothing) {
  write("memory.toml", GetParam().text);
  write("in.csv", "input\n50\n");
  Process program = run("piezo.model.toml", "in.csv", "out.csv", {"--memory", path("memory.toml")});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("memory.toml" + std::string(GetParam().message)), std::string::npos)
      << program.err();
  EXPECT_NE(program.err().find("expected"), std::string::npos) << program.err();
  EXPECT_EQ(std::ranges::count(program.err(), '\n'), 1) << program.err();
  EXPECT_FALSE(std::filesystem::exists(shipped / "out.csv"));
}

#define HYSTCAN_MEMORY "[memory]\nkind = \"recursive-memory\"\norigin = \"virgin\"\n"

INSTANTIATE_TEST_SUITE_P(
    Of, BadMemories,
    testing::Values(
        BadMemory{"AnotherModel", HYSTCAN_MEMORY "input = 3\nmodel = \"0123456789abcdef\"\n",
                  ":5:9: model is \"0123456789abcdef\""},
        BadMemory{"AnotherKind", "[memory]\nkind = \"prandtl-ishlinskii\"\ninput = 3\nplays = [1]\n",
                  ":2:8: kind is \"prandtl-ishlinskii\", expected \"recursive-memory\""},
        BadMemory{"NotNested", HYSTCAN_MEMORY "turning_inputs = [60, 20, 70]\ninput = 3\n",
                  ":4:27: turning point is 70"},
        BadMemory{"OutputsOfAnotherModel",
                  HYSTCAN_MEMORY "turning_inputs = [60]\nturning_outputs = [5.5]\ninput = 3\n",
                  ":4:19: output 5.5"},
        BadMemory{"InputOutside", HYSTCAN_MEMORY "input = 300\n", ":4:9: "},
        BadMemory{"InputMissing", HYSTCAN_MEMORY, ":1:1: missing key input"},
        BadMemory{"NotTheFile", "[hysteresis]\n",
                  ":1:2: unknown key hysteresis, expected one of correction, learning, memory, stop"},
        BadMemory{"NotFinite", HYSTCAN_MEMORY "input = nan\n", ":4:9: input is nan"}),
    [](const auto& test) { return test.param.name; });

TEST_F(Simulate, FindsTheNegativeDriveOfAnEvenModelOnRequest) {
  write("in.csv", "output\n10\n20\n15\n");
  Process positive = run("galfenol.model.toml", "in.csv", "plus.csv", {"--inverse"});
  ASSERT_EQ(positive.wait(), done) << positive.err();
  Process negative = run("galfenol.model.toml", "in.csv", "minus.csv", {"--inverse", "--negative-drive"});
  ASSERT_EQ(negative.wait(), done) << negative.err();
  const auto plus = rows_of(read("plus.csv")), minus = rows_of(read("minus.csv"));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(plus[i].input, 0.0);
    EXPECT_EQ(minus[i].input, -plus[i].input);
    EXPECT_EQ(minus[i].output, plus[i].output);
  }
  write("drive.csv", read("minus.csv"));
  Process back = run("galfenol.model.toml", "drive.csv", "back.csv");
  ASSERT_EQ(back.wait(), done) << back.err();
  EXPECT_NEAR(rows_of(read("back.csv"))[2].output, 15.0, 1e-12);

  Process not_even = run("piezo.model.toml", "in.csv", "no.csv", {"--inverse", "--negative-drive"});
  EXPECT_EQ(not_even.wait(), bad_input);
  EXPECT_NE(not_even.err().find("expected \"even\""), std::string::npos) << not_even.err();
}

TEST_F(Simulate, RunsBeyondTheLimitOnlyOnRequestAndCountsTheRows) {
  shipped.edit("piezo.model.toml", "k_ascending  = 0.035", "k_ascending  = 1.0");
  write("in.csv", "input\n100\n40\n45\n");
  Process refused = run("piezo.model.toml", "in.csv", "out.csv");
  EXPECT_EQ(refused.wait(), bad_input);
  EXPECT_NE(refused.err().find("k_ascending = 1 1/V is too large, at most 0."), std::string::npos)
      << refused.err();
  Process studied = run("piezo.model.toml", "in.csv", "out.csv", {"--beyond-limit"});
  EXPECT_EQ(studied.wait(), done) << studied.err();
  EXPECT_NE(studied.err().find("1 row on a branch that does not increase"), std::string::npos)
      << studied.err();
  Process inverted = run("piezo.model.toml", "in.csv", "out.csv", {"--beyond-limit", "--inverse"});
  EXPECT_EQ(inverted.wait(), bad_input);
}

TEST_F(Simulate, NeedsConstantMemoryForAMillionRowsAndShowsProgress) {
  write_record("short.csv", 1000);
  write_record("long.csv", 1'000'000);
  Process few = run("piezo.model.toml", "short.csv", "few.csv");
  ASSERT_EQ(few.wait(), done) << few.err();
  Process many = run("piezo.model.toml", "long.csv", "many.csv");
  ASSERT_EQ(many.wait(), done) << many.err();
  EXPECT_EQ(many.err().find('%'), std::string::npos) << "a bar where there is no terminal";
  EXPECT_NE(many.err().find("1000000 rows"), std::string::npos) << many.err();
  // If the program kept one number per row, it would need 8000 kB.
  EXPECT_LT(many.peak_resident_kB(), few.peak_resident_kB() + 4000);

  std::string on_terminal;
  for (const auto& word : command("piezo.model.toml", "many.csv", "again.csv")) on_terminal += word + " ";
  Process bar({"script", "--quiet", "--return", "--command", on_terminal, "/dev/null"});
  ASSERT_EQ(bar.wait(), done) << bar.err();
  EXPECT_NE(bar.out().find("%"), std::string::npos) << bar.out();
  EXPECT_EQ(read("again.csv"), read("many.csv"));
}

TEST_F(Simulate, ShowsNoBarOnADumbTerminal) {
  write_record("long.csv", 300'000);
  std::string on_terminal = "TERM=dumb";
  for (const auto& word : command("piezo.model.toml", "long.csv", "out.csv")) on_terminal += " " + word;
  Process program({"script", "--quiet", "--return", "--command", on_terminal, "/dev/null"});
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_EQ(program.out().find('%'), std::string::npos) << program.out();
}

TEST_F(Simulate, ErasesItsBarBeforeItReportsAnError) {
  write_record("long.csv", 300'000);
  std::ofstream(shipped / "long.csv", std::ios::app) << "300,x\n";
  std::string on_terminal = "TERM=xterm";
  for (const auto& word : command("piezo.model.toml", "long.csv", "out.csv")) on_terminal += " " + word;
  Process program({"script", "--quiet", "--return", "--command", on_terminal, "/dev/null"});
  ASSERT_EQ(program.wait(), bad_input) << program.err();
  const std::string screen = program.out();
  EXPECT_NE(screen.find("hystcan: "), std::string::npos) << screen;
  const auto bar = screen.rfind('%');  // none on a fast machine
  const bool erased = bar == std::string::npos || screen.find("\r\033[Khystcan: ", bar) != std::string::npos;
  EXPECT_TRUE(erased) << screen;
}

TEST_F(Simulate, ReportsTheStepsTakenWithAFullMemory) {
  std::string text = "input\n";
  for (int i = 0; i < 5000; ++i)
    text += std::to_string(50 + (i % 2 == 0 ? 1 : -1) * (49.0 - 0.009 * i)) + "\n";
  write("in.csv", text);
  Process program = run("piezo.model.toml", "in.csv", "out.csv");
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.err().find("steps the memory of 4096 turning points was full"), std::string::npos)
      << program.err();
}

TEST_F(Simulate, RefusesTwoOutputsInOneFile) {
  write("in.csv", "input\n1\n");
  for (const std::string& same : {path("x"), path("./x")}) {
    Process program = run("piezo.model.toml", "in.csv", "x", {"--save-memory", same});
    EXPECT_EQ(program.wait(), bad_input) << program.err();
    EXPECT_NE(program.err().find("is written twice"), std::string::npos) << program.err();
    EXPECT_FALSE(std::filesystem::exists(shipped / "x"));
  }
}

TEST_F(Simulate, LeavesNoFileIfItIsStoppedOrTheDiskIsFull) {
  const auto files = [&] {
    return std::distance(std::filesystem::directory_iterator(shipped / ""),
                         std::filesystem::directory_iterator());
  };
  write_record("in.csv", 1000);
  const auto before = files();
  // The input never ends, so that a signal must stop the program.
  Process endless({"sh", "-c",
                   "{ echo input; exec yes 1; } | " HYSTCAN_PROGRAM " simulate " + path("piezo.model.toml") +
                       " --input /dev/stdin --output " + path("out.csv") + " & until ls " + path("out.csv") +
                       ".* >/dev/null 2>&1; do sleep 0.05; done; " + "kill -TERM $!; wait $!"});
  EXPECT_EQ(endless.wait(), failed) << endless.err();
  EXPECT_NE(endless.err().find("stopped in row"), std::string::npos) << endless.err();
  EXPECT_EQ(files(), before);

  Process full({"sh", "-c",
                "trap '' XFSZ; ulimit -f 8; " HYSTCAN_PROGRAM " simulate " + path("piezo.model.toml") +
                    " --input " + path("in.csv") + " --output " + path("out.csv")});
  EXPECT_EQ(full.wait(), failed) << full.err();
  EXPECT_NE(full.err().find("cannot be written: File too large"), std::string::npos) << full.err();
  EXPECT_EQ(files(), before);

  write_record("long.csv", 100'000);
  const auto with_long = files();
  Process full_hdf5({"sh", "-c",
                     "trap '' XFSZ; ulimit -f 8; " HYSTCAN_PROGRAM " simulate " + path("piezo.model.toml") +
                         " --input " + path("long.csv") + " --output " + path("out.h5")});
  EXPECT_EQ(full_hdf5.wait(), failed) << full_hdf5.err();
  EXPECT_TRUE(full_hdf5.err().ends_with("cannot be written: File too large\n")) << full_hdf5.err();
  EXPECT_EQ(files(), with_long);
  std::filesystem::remove(shipped / "long.csv");

  Process nameless(
      {HYSTCAN_PROGRAM, "simulate", path("piezo.model.toml"), "--input", path("in.csv"), "--output", ""});
  EXPECT_EQ(nameless.wait(), bad_input);
  EXPECT_EQ(files(), before);
}

TEST_F(Simulate, WritesTheShortestDigitsThatReadBackToTheSameBits) {
  write("in.csv", "time_s,input\n0.1,50\n0.30000000000000004,50.1\n");
  ASSERT_EQ(run("piezo.model.toml", "in.csv", "out.csv").wait(), done);
  const std::string text = read("out.csv");
  EXPECT_NE(text.find("\n0.1,50,"), std::string::npos) << text;
  EXPECT_NE(text.find("\n0.30000000000000004,50.1,"), std::string::npos) << text;
}

TEST_F(Simulate, ReadsAndWritesTheSameRowsInHdf5AsInCsv) {
  write_record("in.csv", 10'000);
  ASSERT_EQ(run("piezo.model.toml", "in.csv", "out.csv").wait(), done);
  Process to_hdf5 = run("piezo.model.toml", "in.csv", "out.h5");
  ASSERT_EQ(to_hdf5.wait(), done) << to_hdf5.err();
  // Its column `input` contains the values that were read: the output is the same again.
  Process from_hdf5 = run("piezo.model.toml", "out.h5", "again.csv");
  ASSERT_EQ(from_hdf5.wait(), done) << from_hdf5.err();
  EXPECT_EQ(read("again.csv"), read("out.csv"));
  Process inverse = run("piezo.model.toml", "out.h5", "back.h5", {"--inverse"});
  ASSERT_EQ(inverse.wait(), done) << inverse.err();
}

TEST_F(Simulate, RefusesAnHdf5FileWithItsPlaceAndLeavesNothing) {
  write_record("in.csv", 100);
  ASSERT_EQ(run("piezo.model.toml", "in.csv", "out.h5").wait(), done);
  const std::string whole = read("out.h5");
  write("cut.h5", whole.substr(0, whole.size() / 2));
  Process cut = run("piezo.model.toml", "cut.h5", "never.csv");
  EXPECT_EQ(cut.wait(), bad_input);
  EXPECT_NE(cut.err().find("cut.h5: cannot be read, expected an HDF5 file"), std::string::npos) << cut.err();
  Process folder = run("piezo.model.toml", "in.csv", "none/out.h5");
  EXPECT_EQ(folder.wait(), failed);
  EXPECT_FALSE(std::filesystem::exists(shipped / "never.csv"));
}

TEST_F(Simulate, NeedsATableAndAnEvenRateForDynamics) {
  write_record("record.csv", 100);
  Process without = run("piezo.model.toml", "record.csv", "out.csv", {"--dynamics"});
  EXPECT_EQ(without.wait(), bad_input);
  EXPECT_NE(without.err().find("has no [dynamics], expected this table with --dynamics"), std::string::npos);
  std::ofstream(shipped / "piezo.model.toml", std::ios::app)
      << "\n[dynamics]\nresonance_Hz = 200.0\ndamping_ratio = 0.1\ndelay_s = 0.001\n";
  write("uneven.csv", "time_s,input\n0,0\n0.001,1\n0.003,2\n");
  Process uneven = run("piezo.model.toml", "uneven.csv", "out.csv", {"--dynamics"});
  EXPECT_EQ(uneven.wait(), bad_input);
  EXPECT_NE(
      uneven.err().find("uneven.csv: row 3 is 0.002 s after the row before, expected 0.001 s within 1 %"),
      std::string::npos)
      << uneven.err();
  EXPECT_FALSE(std::filesystem::exists(shipped / "out.csv"));
  Process moved = run("piezo.model.toml", "record.csv", "out.csv", {"--dynamics"});
  EXPECT_EQ(moved.wait(), done) << moved.err();
}

}  // namespace
}  // namespace hystcan::simulate_test
