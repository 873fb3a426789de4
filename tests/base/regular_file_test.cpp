#include "base/input_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>

#include "can/dbc/database.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::can::regular_file_test {
namespace {

std::string refusal_of(const std::filesystem::path& file, std::size_t largest = 1000) {
  const std::string text = support::refusal_of([&] { read_regular_file(file, largest); });
  const std::string before = file.string() + ": cannot be read: ";
  return text.starts_with(before) ? text.substr(before.size()) : text;
}

struct RegularFile : testing::Test {
  support::ShippedCopy folder;
  std::filesystem::path file = folder / "file";
};

TEST_F(RegularFile, IsReadWholeUpToTheSizeLimit) {
  std::string text(200'000, 'a');
  text[70'000] = '\0';
  std::ofstream(file, std::ios::binary) << text;
  EXPECT_EQ(read_regular_file(file, text.size()), text);
  EXPECT_EQ(refusal_of(file, text.size() - 1), "the file has more than 199999 bytes");
}

TEST_F(RegularFile, NeedsOnlyTheMemoryOfItsBytes) {
  const std::string text(70'000, 'a');
  std::ofstream(file) << text;
  EXPECT_LE(read_regular_file(file, 1'000'000).capacity(), text.size() + 1);
}

TEST_F(RegularFile, IsReadWholeIfItReportsNoSize) {
  std::string line;
  std::getline(std::ifstream("/proc/version"), line);
  EXPECT_EQ(read_regular_file("/proc/version", line.size() + 1), line + '\n');
  EXPECT_EQ(refusal_of("/proc/version", 20), "the file has more than 20 bytes");
}

TEST_F(RegularFile, MayBeEmpty) {
  std::ofstream(file).flush();
  EXPECT_EQ(read_regular_file(file, 0), "");
}

TEST_F(RegularFile, MayBeNamedByALink) {
  std::ofstream(file) << "text";
  std::filesystem::create_symlink(file, folder / "link");
  EXPECT_EQ(read_regular_file(folder / "link", 4), "text");
}

TEST_F(RegularFile, IsNeitherAPipeNorADeviceNorADirectory) {
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  EXPECT_EQ(refusal_of(file), "the path names a pipe or a device") << "and no writer is waited for";
  EXPECT_EQ(refusal_of("/dev/zero"), "the path names a pipe or a device");
  EXPECT_EQ(refusal_of(folder.folder()), "Is a directory");
  EXPECT_EQ(refusal_of(folder / "none"), "No such file or directory");
}

TEST_F(RegularFile, IsRequiredForADbc) {
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  EXPECT_THROW(load_dbc(file), Error);
}

}  // namespace
}  // namespace hystcan::can::regular_file_test
