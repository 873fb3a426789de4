#include "base/input_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::can::input_stream_test {
namespace {

using std::chrono::milliseconds;

std::string all_of(const std::filesystem::path& file) {
  const auto stream = open_input(file, "a text");
  return {std::istreambuf_iterator<char>(*stream), {}};
}

std::string refusal_of(const std::filesystem::path& file, milliseconds patience = milliseconds(20)) {
  return support::refusal_of([&] { open_input(file, "a text", patience); });
}

struct InputStream : testing::Test {
  void make_fifo() const { ASSERT_EQ(mkfifo(file.c_str(), 0600), 0); }

  support::ShippedCopy folder;
  std::filesystem::path file = folder / "input";
};

TEST_F(InputStream, ReadsAWholeFile) {
  std::string text(200'000, 'a');
  text[70'000] = '\0';
  text[65'536] = '\xFF';
  std::ofstream(file, std::ios::binary) << text;
  EXPECT_EQ(all_of(file), text);
}

TEST_F(InputStream, ReadsAFifoToItsEnd) {
  make_fifo();
  const int reader = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);  // so that the writer can open it
  const int writer = open(file.c_str(), O_WRONLY | O_CLOEXEC);
  ASSERT_EQ(write(writer, "first second", 12), 12);
  const auto stream = open_input(file, "a text", milliseconds(0));
  close(writer);
  close(reader);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(*stream), {}), "first second");
}

TEST_F(InputStream, WaitsForTheWriterOfAFifo) {
  make_fifo();
  const int both = open(file.c_str(), O_RDWR | O_CLOEXEC);
  const auto stream = open_input(file, "a text", milliseconds(0));
  ASSERT_EQ(write(both, "late", 4), 4);
  close(both);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(*stream), {}), "late");
}

TEST_F(InputStream, RefusesAFifoWithoutAWriter) {
  make_fifo();
  EXPECT_EQ(refusal_of(file),
            file.string() +
                ": cannot be read: the path names a pipe, and no program writes to it, expected a text");
}

TEST_F(InputStream, RefusesAFolderAndAnAbsentFile) {
  EXPECT_EQ(refusal_of(folder.folder()),
            folder.folder().string() + ": cannot be read: Is a directory, expected a text");
  EXPECT_EQ(refusal_of(folder / "none"),
            (folder / "none").string() + ": cannot be read: No such file or directory, expected a text");
}

}  // namespace
}  // namespace hystcan::can::input_stream_test
