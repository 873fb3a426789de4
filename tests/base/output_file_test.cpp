// An output file is complete or absent, and no other file remains.
#include "base/output_file.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "tests/support/scratch.h"
#include "tests/support/shipped.h"

namespace hystcan::app::output_file_test {
namespace {

class OutputFiles : public testing::TestWithParam<OutputFile::Kind> {
 protected:
  OutputFiles() { std::ofstream(folder / "file") << "old"; }
  std::vector<std::string> names() const {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      found.push_back(entry.path().filename().string());
    std::ranges::sort(found);
    return found;
  }

  const support::ScratchFolder scratch;
  const std::filesystem::path& folder = scratch.path();
};

TEST_P(OutputFiles, KeepPermissionsAndRefuseAProtectedFile) {
  using std::filesystem::perms;
  const perms own = perms::owner_read | perms::owner_write;
  std::filesystem::permissions(folder / "file", own);
  OutputFile file(folder / "file", GetParam());
  file.write("new");
  file.commit();
  EXPECT_EQ(std::filesystem::status(folder / "file").permissions(), own);
  std::filesystem::permissions(folder / "file", perms::owner_read);
  EXPECT_THROW(OutputFile(folder / "file", GetParam()), RunError);
  EXPECT_EQ(names(), std::vector<std::string>{"file"});
}

TEST_P(OutputFiles, ReplaceTheOldFileAtTheirCommit) {
  OutputFile file(folder / "file", GetParam());
  file.write("new");
  EXPECT_EQ(support::read_file(folder / "file"), "old");
  file.commit();
  EXPECT_EQ(support::read_file(folder / "file"), "new");
  EXPECT_EQ(names(), std::vector<std::string>{"file"});
}

TEST_P(OutputFiles, LeaveTheOldFileAloneWithoutACommit) {
  { OutputFile(folder / "file", GetParam()).write("new"); }
  EXPECT_EQ(support::read_file(folder / "file"), "old");
  EXPECT_EQ(names(), std::vector<std::string>{"file"});
}

INSTANTIATE_TEST_SUITE_P(Kinds, OutputFiles,
                         testing::Values(OutputFile::Kind::plain, OutputFile::Kind::durable));

TEST_F(OutputFiles, FollowALinkUnlessTheyAreDurable) {
  for (const auto kind : {OutputFile::Kind::plain, OutputFile::Kind::durable}) {
    std::filesystem::create_symlink("file", folder / "link");
    OutputFile file(folder / "link", kind);
    file.write("new");
    file.commit();
    const bool is_link = std::filesystem::is_symlink(folder / "link");
    EXPECT_EQ(is_link, kind == OutputFile::Kind::plain);
    std::filesystem::remove(folder / "link");
    EXPECT_EQ(support::read_file(folder / "file"), "new");
  }
}

}  // namespace
}  // namespace hystcan::app::output_file_test
