// `hystcan plot` as a process, with the CSV files of the demo.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "tests/app/command_line/cli.h"
#include "tests/support/long_run.h"

namespace hystcan::plot_test {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

class Plot : public Cli {
 protected:
  Plot() {
    Process demo({HYSTCAN_PROGRAM, "demo", "--all", "--config", path("piezo.toml"), "--output",
                  (shipped / "demo").string()});
    EXPECT_EQ(demo.wait(), done) << demo.err();
  }
  std::string csv(const char* structure) const { return (shipped / "demo" / structure).string() + ".csv"; }
  Process plot(Words more) const {
    Words words{HYSTCAN_PROGRAM, "plot", "--output", (shipped / "plots").string()};
    words.insert(words.end(), more.begin(), more.end());
    return Process(words);
  }
  fs::path picture(const std::string& name) const { return shipped / "plots" / name; }
};

TEST_F(Plot, DrawsEveryKindInEveryFormat) {
  Process program = plot({csv("pi"), csv("inverse+pi"), "--axis", "x"});
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_EQ(program.err().find("arning"), std::string::npos) << program.err();
  for (const char* kind : {"loops", "tracking", "error", "spectrum", "timing"})
    for (const char* format : {".svg", ".png", ".pdf"})
      EXPECT_GT(fs::file_size(picture(std::string("inverse+pi-x-") + kind + format)), 3000U)
          << kind << format;
  EXPECT_TRUE(fs::exists(picture("comparison.pdf")));
}

TEST_F(Plot, NamesUnitsOnEveryAxis) {
  ASSERT_EQ(plot({csv("pi"), csv("inverse+pi"), "--axis", "x", "--format", "svg"}).wait(), done);
  for (const auto& [name, x, y] :
       {std::tuple("pi-x-loops", "drive (drive unit)", "position (um)"),
        std::tuple("pi-x-tracking", "time (s)", "position (um)"),
        std::tuple("pi-x-error", "time (s)", "error (um)"),
        std::tuple("pi-x-spectrum", "frequency (Hz)", "error (um/√Hz)"),
        std::tuple("pi-x-timing", "time (us)", "cycles (%)"),
        std::tuple("comparison", "time since the first cycle (s)", "error (um)")}) {
    const std::string svg = support::read_file(picture(name).string() + ".svg");
    EXPECT_NE(svg.find(std::string(">") + x + "</text>"), std::string::npos) << name;
    EXPECT_NE(svg.find(std::string(">") + y + "</text>"), std::string::npos) << name;
  }
}

TEST_F(Plot, HasNoTextOutsideThePicture) {
  ASSERT_EQ(plot({csv("pi"), "--axis", "x", "--format", "svg"}).wait(), done);
  const std::regex place("<text [^>]*x=\"([0-9.-]+)\" y=\"([0-9.-]+)\"");
  const std::regex box("viewBox=\"0 0 ([0-9.]+) ([0-9.]+)\"");
  for (const auto& entry : fs::directory_iterator(shipped / "plots")) {
    if (entry.path().extension() != ".svg") continue;
    const std::string svg = support::read_file(entry.path());
    std::smatch size;
    ASSERT_TRUE(std::regex_search(svg, size, box));
    std::sregex_iterator text(svg.begin(), svg.end(), place), end;
    EXPECT_NE(text, end) << entry.path();
    for (; text != end; ++text) {
      EXPECT_GE(std::stod((*text)[1]), 0.0) << entry.path();
      EXPECT_LE(std::stod((*text)[1]), std::stod(size[1])) << entry.path();
      EXPECT_LE(std::stod((*text)[2]), std::stod(size[2])) << entry.path();
    }
  }
}

TEST_F(Plot, PrintsTheTableOfItsRuns) {
  Process program = plot({csv("pi"), csv("inverse+pi"), "--axis", "x", "--kind", "error", "--format", "svg",
                          "--table", "markdown"});
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_TRUE(std::regex_search(program.out(), std::regex("\n\\| pi \\| x \\| [0-9]+ \\| [0-9.]+ \\|")))
      << program.out();
}

TEST_F(Plot, RefusesAxesKindsAndTimesMissingFromTheRun) {
  const std::string cycles = support::read_file(csv("pi"));
  write("header.csv", cycles.substr(0, cycles.find("\n", cycles.find("time_s")) + 1));
  for (const auto& [words, expected] :
       {std::pair(Words{csv("pi"), "--axis", "z"}, "no axis z"),
        std::pair(Words{csv("pi"), "--kind", "pie"}, "expected one of loops"),
        std::pair(Words{csv("pi"), "--from", "99"}, "does not track in this interval"),
        std::pair(Words{path("header.csv")}, "has no axes and no rows"),
        std::pair(Words{path("piezo.toml")}, "expected a run's folder")}) {
    Process program = plot(words);
    EXPECT_EQ(program.wait(), bad_input) << program.err();
    EXPECT_NE(program.err().find(expected), std::string::npos) << program.err();
  }
}

TEST_F(Plot, WritesItsDataIfPythonIsMissing) {
  write("no-matplotlib", "#!/bin/sh\nexec /usr/bin/python3 -S \"$@\"\n");
  fs::permissions(shipped / "no-matplotlib", fs::perms::owner_all);
  for (const auto& [interpreter, reason] :
       {std::pair(std::string("/nonexistent"),
                  "no pictures: /nonexistent cannot be started: No such file or directory; "
                  "install python3-matplotlib; the data files (.csv) are complete"),
        std::pair(path("no-matplotlib"),
                  "no pictures: the Python module matplotlib is missing; install python3-matplotlib; "
                  "the data files (.csv) are complete")}) {
    write("plots/pi-x-loops.svg", "earlier");
    Process program({"env", "HYSTCAN_PYTHON=" + interpreter, HYSTCAN_PROGRAM, "plot", csv("pi"), "--axis",
                     "x", "--kind", "loops", "--output", (shipped / "plots").string()});
    EXPECT_EQ(program.wait(), failed);
    EXPECT_NE(program.err().find(reason), std::string::npos) << program.err();
    EXPECT_TRUE(fs::exists(picture("pi-x-loops.csv")));
    EXPECT_FALSE(fs::exists(picture("pi-x-loops.svg"))) << "of an earlier run";
  }
}

TEST_F(Plot, RepeatsAPictureFromItsList) {
  ASSERT_EQ(plot({csv("pi"), "--axis", "x", "--kind", "loops", "--format", "svg"}).wait(), done);
  const std::string before = support::read_file(picture("pi-x-loops.svg"));
  fs::remove(picture("pi-x-loops.svg"));
  Process again(
      {"/usr/bin/python3", HYSTCAN_SOURCE_DIR "/python/hystcan/plot.py", picture("pictures.json").string()});
  ASSERT_EQ(again.wait(), done) << again.err();
  EXPECT_EQ(support::read_file(picture("pi-x-loops.svg")), before);
}

TEST_F(Plot, ShowsFormulasInNamesAsText) {
  std::string rows = support::read_file(csv("pi"));
  for (std::size_t at = 0; (at = rows.find(",x,", at)) != std::string::npos;)
    rows.replace(at, 3, ",$x_1^2$,");
  write("own.csv", rows);
  Process program = plot({path("own.csv"), csv("pi"), "--kind", "comparison", "--format", "svg"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const std::string svg = support::read_file(picture("comparison.svg"));
  EXPECT_NE(svg.find(">own-$x_1^2$: RMS "), std::string::npos);
}

// A run from another user may have any axis and file names.
TEST_F(Plot, DrawsTheNamesOfRunsAndAxesAsText) {
  const std::string rows = support::read_file(csv("pi"));
  const Words names{"x';system(\"touch EXECUTED\");#",
                    "/../../outside",
                    "`touch EXECUTED`",
                    "| touch EXECUTED",
                    "< touch EXECUTED",
                    "-e",
                    ".hidden",
                    "a_b^{2}@~\\"};
  const std::size_t stride = support::long_run() ? 1 : 2;
  for (std::size_t i = 0; i < names.size(); i += stride) {
    std::string text;
    std::istringstream lines(rows);
    for (std::string line; std::getline(lines, line);) {
      if (const std::size_t at = line.find(",x,"); at != std::string::npos) line.replace(at + 1, 1, names[i]);
      text += line + "\n";
    }
    std::string file_name = names[names.size() - 1 - i];
    std::ranges::replace(file_name, '/', '!');
    const fs::path file = (shipped / file_name.c_str()).string() + ".csv";
    std::ofstream(file) << text;
    Process program = plot(
        {fs::absolute(file).string(), csv("pi"), "--axis", names[i], "--kind", "loops", "--format", "svg"});
    program.wait();
    Process both =
        plot({fs::absolute(file).string(), csv("pi"), "--kind", "loops,comparison", "--format", "svg"});
    EXPECT_EQ(both.wait(), done) << names[i] << both.err();
  }
  const std::regex allowed("[A-Za-z0-9_+.-]+\\.(csv|json|svg)");
  std::size_t pictures = 0;
  for (const auto& entry : fs::recursive_directory_iterator(shipped / "plots")) {
    EXPECT_TRUE(std::regex_match(entry.path().filename().string(), allowed)) << entry.path();
    pictures += entry.path().extension() == ".svg" ? 1 : 0;
  }
  EXPECT_GT(pictures, names.size() / stride);
  for (const auto& entry : fs::recursive_directory_iterator(shipped / "."))
    EXPECT_NE(entry.path().filename(), "EXECUTED") << entry.path();
  EXPECT_FALSE(fs::exists("EXECUTED"));
}

TEST_F(Plot, LeavesNoIncompletePictureOnAFullDisk) {
  Process program({"sh", "-c",
                   "ulimit -f 8; " HYSTCAN_PROGRAM " plot " + csv("pi") +
                       " --axis x --kind spectrum --format svg,png --output " +
                       (shipped / "plots").string()});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("cannot be written: File too large"), std::string::npos) << program.err();
  for (const auto& entry : fs::directory_iterator(shipped / "plots"))
    EXPECT_TRUE(entry.path().extension() == ".csv" || entry.path().extension() == ".json") << entry.path();
}

}  // namespace
}  // namespace hystcan::plot_test
