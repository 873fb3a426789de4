// `hystcan runs` and `hystcan export` as processes.
#include <filesystem>
#include <fstream>

#include "tests/app/command_line/cli.h"

namespace hystcan::runs_command_test {
namespace {

class Runs : public Cli {
 protected:
  /// Three cycles of one axis.
  std::string cycles() const {
    std::ofstream(shipped / "c.csv") << "cycle,time_s,axis,state,fault,error_um,position_um\n"
                                        "1,0.001,x,tracking,none,0.5,1.25\n"
                                        "2,0.002,x,tracking,none,0.5,1.5\n"
                                        "3,0.003,x,faulted,following error,,1.75\n";
    return path("c.csv");
  }
};

TEST_F(Runs, ExportWritesTheSelectedSignals) {
  Process process({HYSTCAN_PROGRAM, "export", "--signals", "position_um,state", cycles(), "--from", "0.002"});
  EXPECT_EQ(process.wait(), 0) << process.err();
  EXPECT_TRUE(process.out().ends_with("\ntime_s,position_um,state\n0.002,1.5,tracking\n0.003,1.75,faulted\n"))
      << process.out();
}

TEST_F(Runs, AreListedEvenIfOneIsUnreadable) {
  const std::filesystem::path folder = shipped / "runs";
  std::filesystem::create_directories(folder / "run_1");
  std::ofstream(folder / "run_1" / "run.json") << "{}";
  Process process({HYSTCAN_PROGRAM, "runs", folder.string()});
  EXPECT_EQ(process.wait(), 0) << process.err();
  EXPECT_NE(process.err().find("run_1/run.json"), std::string::npos) << process.err();
  EXPECT_NE(process.out().find("1 run, "), std::string::npos) << process.out();
}

}  // namespace
}  // namespace hystcan::runs_command_test
