#include "config/files/csv.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/refusal.h"
#include "tests/support/scratch.h"

namespace hystcan::config::csv_test {
namespace {

class Csv : public testing::Test {
 protected:
  CsvReader reader(const std::string& text, std::vector<std::string> columns = {"input"}) {
    std::ofstream(file_, std::ios::binary) << text;
    return {file_, std::move(columns)};
  }
  std::vector<double> all(const std::string& text) {
    CsvReader csv = reader(text);
    std::vector<double> row;
    std::vector<double> values;
    while (csv.next(row)) values.push_back(row[0]);
    return values;
  }
  std::string refusal(const std::string& text) {
    const std::string message = support::refusal_of([&] { all(text); });
    return message == "accepted" ? message : message.substr(file_.string().size());
  }
  std::filesystem::path file_ = support::scratch_file("data.csv");
};

TEST_F(Csv, FindsColumnsByNameInAnyOrder) {
  CsvReader csv = reader("# made by hand\noutput, time_s ,input\n1,2,3\n", {"input", "output"});
  std::vector<double> row;
  ASSERT_TRUE(csv.next(row));
  EXPECT_EQ(row, (std::vector<double>{3.0, 1.0}));
  EXPECT_FALSE(csv.next(row));
}

TEST_F(Csv, AcceptsWindowsLineEndsCommentsAndBlankLines) {
  EXPECT_EQ(all("time_s,input\r\n0,1.5\r\n\r\n# pause\r\n1,-2e-3\r\n"), (std::vector<double>{1.5, -0.002}));
}

TEST_F(Csv, AcceptsFilesOfSpreadsheets) {
  EXPECT_EQ(all("\xEF\xBB\xBFinput,time_s\n+1.5,0\n  # pause\n-2,1\n"), (std::vector<double>{1.5, -2.0}));
  EXPECT_EQ(refusal("input\n+-1\n"), ":2:1: input is \"+-1\", expected a finite number");
}

TEST_F(Csv, ReadsDecimalCommasBetweenSemicolonsOrTabs) {
  EXPECT_EQ(all("time_s;input\r\n0,5;1,25\r\n1;-2\r\n"), (std::vector<double>{1.25, -2.0}));
  EXPECT_EQ(all("time_s\tinput\n0.5\t1,25e-3\n"), (std::vector<double>{1.25e-3}));
  EXPECT_EQ(refusal("time_s,input\n0,5,1,25\n"),
            ":2:1: the row has 4 fields, expected 2 as in the header: decimal commas need semicolons "
            "between the fields");
  EXPECT_EQ(refusal("input;x\n1,2,3;0\n"), ":2:1: input is \"1,2,3\", expected a finite number");
}

TEST_F(Csv, ReadsANamedValueFromACommentBeforeTheHeader) {
  const CsvReader csv = reader("# input_unit = \"V\"\n#output_unit=um\ninput\n# input_unit = A\n1\n");
  EXPECT_EQ(csv.comment("input_unit"), "V");
  EXPECT_EQ(csv.comment("output_unit"), "um");
  EXPECT_EQ(csv.comment("licence"), "");
}

TEST_F(Csv, LeavesOutALastRowThatWasCutAndZeros) {
  const auto notes = [&](const std::string& text) {
    CsvReader csv = reader(text);
    std::vector<double> row;
    EXPECT_TRUE(csv.next(row));
    EXPECT_FALSE(csv.next(row)) << text;
    return csv.notes();
  };
  using Notes = std::vector<std::string>;
  const std::string cut = "ignoring the last row: it has no line end and may be incomplete";
  EXPECT_EQ(notes("input,x\n1,2\n"), Notes{});
  EXPECT_EQ(notes("input,x\n1,2\n3"), Notes{cut});
  EXPECT_EQ(notes("input,x\n1,2\n3,2.7"), Notes{cut}) << "it can be 2.71";
  EXPECT_EQ(notes("input,x\n1,2\n" + std::string(512, '\0')), Notes{"ignoring 512 zero bytes at the end"});
  EXPECT_EQ(notes("input,x\n1,2\n3," + std::string(1, '\0')),
            (Notes{cut, "ignoring 1 zero byte at the end"}));
}

TEST_F(Csv, RefusesAColumnThatOccursTwice) {
  EXPECT_EQ(refusal("input,output,input\n1,2,3\n"),
            ":1:14: column input occurs twice, expected each name once");
}

TEST_F(Csv, RefusesAnEmptyFieldAtItsPlace) {
  EXPECT_EQ(refusal("time_s,input\n0,1\n1,\n"), ":3:3: input is empty, expected a number");
}

TEST_F(Csv, RefusesAValueThatIsNotFiniteAtItsPlace) {
  EXPECT_EQ(refusal("time_s,input\n0, volts\n"), ":2:4: input is \"volts\", expected a finite number");
  EXPECT_EQ(refusal("input\nnan\n"), ":2:1: input is \"nan\", expected a finite number");
  EXPECT_EQ(refusal("input\n1.5x\n"), ":2:1: input is \"1.5x\", expected a finite number");
}

TEST_F(Csv, RefusesARowThatEndsEarly) {
  EXPECT_EQ(refusal("time_s,input\n0,1\n1\n"), ":3:1: the row has 1 field, expected 2 as in the header");
}

TEST_F(Csv, RefusesAHeaderWithoutTheColumn) {
  EXPECT_EQ(refusal("time_s,volts\n0,1\n"),
            ":1:1: no column input, expected a column with this name among time_s, volts");
}

std::string columns(std::size_t count) {
  std::string header = "input";
  for (std::size_t i = 1; i < count; ++i) header += ",c" + std::to_string(i);
  return header;
}

TEST_F(Csv, HasALimitOfColumns) {
  EXPECT_EQ(refusal(columns(most_columns) + "\n"), "accepted");
  EXPECT_EQ(refusal(columns(most_columns + 1) + "\n"), ":1:1: 4097 columns, expected at most 4096");
  EXPECT_EQ(refusal("a" + columns(100) + "\n").substr(0, 81),
            ":1:1: no column input, expected a column with this name among ainput, c1, c2, c3,");
  EXPECT_TRUE(refusal("a" + columns(100) + "\n").ends_with("c19 and 80 more"));
}

TEST_F(Csv, HasALimitOfALine) {
  const std::string longest = "input\n1" + std::string(longest_csv_line - 1, ' ');
  EXPECT_EQ(refusal(longest + "\n"), "accepted");
  EXPECT_EQ(refusal(longest), "accepted") << "the last line has no end";
  EXPECT_EQ(refusal(longest + " \n"), ":2:1048577: the line is too long, expected at most 1048576 bytes");
  EXPECT_EQ(refusal(std::string(3 * longest_csv_line, '\0')),
            ":1:1048577: the line is too long, expected at most 1048576 bytes");
}

TEST_F(Csv, LooksForNamedValuesInTheFirstCommentsOnly) {
  std::string comments;
  for (std::size_t i = 0; i < most_comments; ++i) comments += "# pause\n";
  EXPECT_EQ(reader(comments + "# input_unit = V\ninput\n1\n").comment("input_unit"), "");
  EXPECT_EQ(reader("# input_unit = V\n" + comments + "input\n1\n").comment("input_unit"), "V");
}

TEST_F(Csv, ShortensALongTextInAMessage) {
  EXPECT_EQ(refusal("input\n" + std::string(1000, 'x') + "\n"),
            ":2:1: input is \"" + std::string(60, 'x') + "...\", expected a finite number");
}

TEST_F(Csv, RefusesADeviceAndAFolderInOneLine) {
  const auto refusal_of = [](const char* file) -> std::string {
    return support::refusal_of([&] { const CsvReader csv(CsvLines(file), {"input"}); });
  };
  EXPECT_EQ(refusal_of("/dev/zero"),
            "/dev/zero:1:1048577: the line is too long, expected at most 1048576 bytes");
  EXPECT_EQ(refusal_of("/"), "/: cannot be read: Is a directory, expected a CSV file");
}

TEST_F(Csv, RefusesAnEmptyFile) { EXPECT_EQ(refusal(""), ":1:1: no header row, expected column names"); }

}  // namespace
}  // namespace hystcan::config::csv_test
