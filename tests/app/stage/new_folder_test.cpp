#include "app/stage/new_folder.h"

#include <gtest/gtest.h>

#include <exception>
#include <fstream>
#include <string>

#include "base/error.h"
#include "tests/support/refusal.h"
#include "tests/support/scratch.h"

namespace hystcan::app::new_folder_test {
namespace {

std::size_t entries(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

TEST(NewFolder, HasItsFilesOnceItIsComplete) {
  const support::ScratchFolder above;
  {
    NewFolder folder(above / "stage/");
    std::ofstream(folder.path() / "file") << "text";
    EXPECT_FALSE(exists(above / "stage"));
    folder.commit();
  }
  EXPECT_TRUE(exists(above / "stage" / "file"));
  EXPECT_EQ(entries(above.path()), 1u);
}

TEST(NewFolder, LeavesNothingIfItIsNotComplete) {
  const support::ScratchFolder above;
  { std::ofstream(NewFolder(above / "stage").path() / "file") << "text"; }
  EXPECT_EQ(entries(above.path()), 0u);
}

TEST(NewFolder, ReplacesAnEmptyFolder) {
  const support::ScratchFolder above;
  std::filesystem::create_directory(above / "stage");
  NewFolder folder(above / "stage");
  std::ofstream(folder.path() / "file") << "text";
  folder.commit();
  EXPECT_TRUE(exists(above / "stage" / "file"));
}

TEST(NewFolder, OverwritesNothing) {
  const support::ScratchFolder above;
  std::filesystem::create_directory(above / "stage");
  std::ofstream(above / "stage" / "mine") << "text";
  std::ofstream(above / "file") << "text";
  EXPECT_THROW(NewFolder(above / "stage"), Error);
  EXPECT_THROW(NewFolder(above / "file"), Error);
  EXPECT_THROW(NewFolder(""), Error);
}

std::string refusal(const std::filesystem::path& path) {
  return support::refusal_of<std::exception>([&] { NewFolder folder(path); });
}

TEST(NewFolder, NamesTheGivenPathAndTheUnwritableFolder) {
  const support::ScratchFolder above;
  std::ofstream(above / "file") << "text";
  // Nobody can make a folder in /proc, not even root.
  EXPECT_TRUE(refusal("/proc/stage").starts_with("/proc/stage: cannot be created in the folder /proc: "));
  EXPECT_TRUE(
      refusal("/proc/a/stage/").starts_with("/proc/a/stage/: cannot be created in the folder /proc: "));
  const std::string file = (above / "file").string();
  EXPECT_EQ(refusal(above / "file/a"), file + "/a: " + file + " is not a folder");
}

}  // namespace
}  // namespace hystcan::app::new_folder_test
