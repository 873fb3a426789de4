#include "runs/run.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "runs/cycle_reader.h"
#include "tests/runs/scratch_runs.h"
#include "tests/support/refusal.h"

namespace hystcan::runs::cycle_reader_test {
namespace {

class CyclesOfAFile : public ScratchRuns {
 protected:
  std::filesystem::path write(const std::string& text) const {
    std::ofstream(folder / "c.csv") << text;
    return folder / "c.csv";
  }
  std::string refusal_of(const std::string& text, const std::string& column = "position_um") const {
    return support::refusal_of([&] {
      CycleReader reader(write(text));
      reader.add(column);
      std::vector<double> row;
      for (std::string_view axis; reader.next(row, axis);) {
      }
    });
  }
  const std::string header = "cycle,time_s,axis,state,fault,position_um,limits\n";
};

TEST_F(CyclesOfAFile, AreReadByTheNamesOfTheirColumns) {
  CycleReader reader(
      write("# remark\n" + header + "7,0.5,x,tracking,none,1.25,slew+model\n8,0.6,y,faulted,none,,\n"));
  for (const char* column : {"limits", "state", "position_um"}) EXPECT_TRUE(reader.add(column));
  EXPECT_FALSE(reader.add("integral_um")) << "an older version did not write it";
  std::vector<double> row;
  std::string_view axis;
  ASSERT_TRUE(reader.next(row, axis));
  EXPECT_EQ(axis, "x");
  EXPECT_EQ(row, (std::vector<double>{10.0, 4.0, 1.25}));
  ASSERT_TRUE(reader.next(row, axis));
  EXPECT_EQ(axis, "y");
  EXPECT_EQ(row[0], 0.0);
  EXPECT_TRUE(std::isnan(row[2]));
  EXPECT_FALSE(reader.next(row, axis));
}

TEST_F(CyclesOfAFile, AreFoundByTheHeaderAlone) {
  EXPECT_TRUE(has_cycles(write("\xEF\xBB\xBF# remark\r\n\n" + header + "damaged")));
  EXPECT_TRUE(has_cycles(write("state,axis,position_um,time_s,cycle\r\n")));
  EXPECT_FALSE(has_cycles(write("time_s,input,output\n" + header)));
  EXPECT_FALSE(has_cycles(write("# remark\n")));
  EXPECT_FALSE(has_cycles(folder / "none"));
}

TEST_F(CyclesOfAFile, EndBeforeALastLineWithoutItsEnd) {
  const std::string row_text = header + "7,0.5,x,tracking,none,1.25,\n";
  for (const std::string& cut : {std::string("8,0.6,x,trac"), std::string(100'000, '\0')}) {
    const RecordedRun run(write(row_text + cut));
    EXPECT_EQ(run.read(0, std::vector<std::string>{"cycle"}), (Columns{{7.0}}));
    EXPECT_EQ(run.notes().size(), 1U);
  }
  EXPECT_TRUE(RecordedRun(write(row_text)).notes().empty());
}

TEST_F(CyclesOfAFile, AreRefusedWithTheirLine) {
  const std::string file = (folder / "c.csv").string();
  EXPECT_EQ(refusal_of(header + "7,0.5,x\n"),
            file + ":2:1: the row has 3 fields, expected 7 as in the header");
  EXPECT_EQ(refusal_of(header + "7,0.5,x,tracking,none,far,\n"),
            file + ":2:23: position_um is \"far\", expected a number");
  EXPECT_EQ(
      refusal_of(header + "7,0.5,x,flying,none,1,\n", "state"),
      file + ":2:9: state is \"flying\", expected the name of an axis state in this version of hystcan");
  EXPECT_EQ(refusal_of("time_s,input,output\n"),
            file +
                ":1:1: no column cycle, expected a run's folder or a CSV of control cycles (from hystcan "
                "controller --csv)");
  EXPECT_EQ(refusal_of(""),
            file + ":1:1: no header row, expected a CSV of control cycles (from hystcan controller --csv)");
  EXPECT_NE(refusal_of(header + std::string(100'000, 'x') + "\n"), "accepted");
  EXPECT_NE(refusal_of(header, "velocity").find("no signal velocity, expected one of cycle, time_s"),
            std::string::npos);
}

}  // namespace
}  // namespace hystcan::runs::cycle_reader_test
