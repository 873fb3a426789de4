#include "base/append_file.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/file_size_limit.h"
#include "tests/support/shipped.h"

namespace hystcan::append_file_test {
namespace {

std::string line_of(std::size_t bytes) { return std::string(bytes - 1, 'a') + '\n'; }

struct GrowingFile : testing::Test {
  support::ShippedCopy folder;
  std::filesystem::path path = folder / "rows.csv";
};

TEST_F(GrowingFile, ContainsLinesOfEachSizeInOrder) {
  AppendFile file(path, AppendFile::Existing::refuse);
  std::string all;
  for (const std::size_t bytes : {1U, 65'535U, 2U, 65'536U, 3U, 65'537U, 1U, 300'000U, 40'000U, 40'000U}) {
    file.add(line_of(bytes));
    all += line_of(bytes);
  }
  EXPECT_FALSE(file.close());
  EXPECT_EQ(support::read_file(path), all);
  EXPECT_EQ(file.written_bytes(), all.size());
}

TEST_F(GrowingFile, EndsWithAWholeLineIfTheDiskIsFull) {
  AppendFile file(path, AppendFile::Existing::refuse);
  {
    const support::FileSizeLimit full(150'000);
    file.add(line_of(40'000));
    file.add(line_of(60'000) + line_of(30'000) + line_of(30'000));
  }
  file.add(line_of(10));
  EXPECT_EQ(file.close(), std::errc::file_too_large);
  EXPECT_EQ(support::read_file(path), line_of(40'000) + line_of(60'000) + line_of(30'000));
  EXPECT_EQ(file.written_bytes(), 130'000U);
}

}  // namespace
}  // namespace hystcan::append_file_test
