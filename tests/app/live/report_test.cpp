// The report of `hystcan identify`.
#include <cmath>
#include <filesystem>
#include <numbers>

#include "tests/app/command_line/cli.h"

namespace hystcan::report_test {
namespace {

class Report : public Cli {
 protected:
  /// A growing oscillation between 0 and 100, and the output of the shipped model.
  void write_record() const {
    std::ofstream out(shipped / "input.csv");
    out.precision(17);
    out << "time_s,input\n";
    for (int i = 0; i <= 1200; ++i)
      out << 1e-3 * i << ','
          << (0.5 + 0.5 * i / 1200) * 50.0 * (1.0 - std::cos(2.0 * std::numbers::pi * i / 100)) << '\n';
    out.close();
    EXPECT_EQ(Process({HYSTCAN_PROGRAM, "simulate", path("piezo.model.toml"), "--input", path("input.csv"),
                       "--output", path("data.csv")})
                  .wait(),
              done);
  }
  Process identify() const {
    return Process({HYSTCAN_PROGRAM, "identify", path("data.csv"), "--order", "3", "--output",
                    path("found.toml"), "--report", path("report")});
  }
};

TEST_F(Report, ContainsAPageAndTheNumbers) {
  write_record();
  Process process = identify();
  ASSERT_EQ(process.wait(), done) << process.err();
  for (const char* name : {"report.html", "record.csv", "curves.csv", "landscape.csv", "comparison.csv",
                           "loops.svg", "landscape.svg", "pictures.json"})
    EXPECT_TRUE(std::filesystem::exists(shipped / "report" / name)) << name;
  const std::string page = read("report/report.html");
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("http"), std::string::npos) << "something from outside";
  for (const char* model : {"recursive memory-based, order 3", "average, order 3", "linear mapping",
                            "Prandtl-Ishlinskii, 9 plays", "Prandtl-Ishlinskii, 30 plays", "Preisach"})
    EXPECT_NE(page.find(model), std::string::npos) << model;
}

TEST_F(Report, DoesNotChangeOtherFilesOfItsFolder) {
  write_record();
  std::filesystem::create_directory(shipped / "report");
  write("report/notes.txt", "mine");
  write("report/report.html", "earlier");
  ASSERT_EQ(identify().wait(), done);
  EXPECT_EQ(read("report/notes.txt"), "mine");
  EXPECT_NE(read("report/report.html"), "earlier");
}

TEST_F(Report, KeepsTheEarlierReportIfTheDiskIsFull) {
  write_record();
  std::filesystem::create_directory(shipped / "report");
  write("report/report.html", "earlier");
  // The file size limit of the process replaces a full disk: 8 kB suffice for the model, but not for the
  // record.
  Process process({"sh", "-c",
                   "trap '' XFSZ; ulimit -f 16; exec " HYSTCAN_PROGRAM " identify " + path("data.csv") +
                       " --order 3 --output " + path("found.toml") + " --report " + path("report")});
  EXPECT_EQ(process.wait(), failed);
  EXPECT_NE(process.err().find("record.csv: cannot be written: File too large"), std::string::npos)
      << process.err();
  EXPECT_EQ(read("report/report.html"), "earlier");
  const auto files = std::filesystem::directory_iterator(shipped / "report");
  EXPECT_EQ(std::distance(begin(files), end(files)), 1) << "no part of the new one";
}

TEST_F(Report, IsRefusedIfItsFolderIsAFile) {
  write_record();
  write("report", "a file");
  Process process = identify();
  EXPECT_EQ(process.wait(), bad_input);
  EXPECT_NE(process.err().find("expected one for the output"), std::string::npos) << process.err();
}

TEST_F(Report, NeverOverwritesItsInput) {
  write_record();
  std::filesystem::create_directory(shipped / "report");
  std::filesystem::copy_file(shipped / "data.csv", shipped / "report" / "record.csv");
  Process process({HYSTCAN_PROGRAM, "identify", path("report/record.csv"), "--output", path("found.toml"),
                   "--report", path("report")});
  EXPECT_EQ(process.wait(), bad_input);
  EXPECT_NE(process.err().find("is also an input"), std::string::npos) << process.err();
}

}  // namespace
}  // namespace hystcan::report_test
