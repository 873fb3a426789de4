// `hystcan migrate` as a process.
#include <filesystem>

#include "tests/app/command_line/cli.h"

namespace hystcan::migrate_command_test {
namespace {

class Migrate : public Cli {
 protected:
  /// A shipped file without its format.
  void make_old(const char* name) const {
    std::string text = read(name);
    text.erase(text.find("format = 1\n"), 11);
    write(name, text);
  }
};

TEST_F(Migrate, ShowsTheDifferenceAndWritesNothing) {
  make_old("piezo.toml");
  const std::string before = read("piezo.toml");
  Process process({HYSTCAN_PROGRAM, "migrate", path("piezo.toml")});
  EXPECT_EQ(process.wait(), 0) << process.err();
  EXPECT_TRUE(process.out().starts_with(path("piezo.toml") + ": from format 0 to 1\n")) << process.out();
  EXPECT_NE(process.out().find("\n+ format = 1\n"), std::string::npos) << process.out();
  EXPECT_EQ(read("piezo.toml"), before);
}

TEST_F(Migrate, WritesTheNewestFormatAndKeepsTheFormerFile) {
  make_old("piezo.toml");
  const std::string before = read("piezo.toml");
  Process process({HYSTCAN_PROGRAM, "migrate", path("piezo.toml"), "--write"});
  EXPECT_EQ(process.wait(), 0) << process.err();
  EXPECT_NE(read("piezo.toml").find("\nformat = 1\n"), std::string::npos);
  EXPECT_EQ(read("piezo.toml.before-save"), before);
  Process again({HYSTCAN_PROGRAM, "migrate", path("piezo.toml"), "--write"});
  EXPECT_EQ(again.wait(), 0);
  EXPECT_EQ(again.out(), path("piezo.toml") + ": format 1, nothing to do\n");
}

TEST_F(Migrate, WritesNoFileIfOneOfThemCannotBeRead) {
  make_old("piezo.toml");
  write("newer.toml", "format = 9\n");
  const std::string before = read("piezo.toml");
  Process process({HYSTCAN_PROGRAM, "migrate", path("piezo.toml"), path("newer.toml"), "--write"});
  EXPECT_EQ(process.wait(), 2);
  EXPECT_NE(process.err().find("newer.toml:1:10: format is 9, written for a newer hystcan"),
            std::string::npos)
      << process.err();
  EXPECT_EQ(read("piezo.toml"), before);
}

}  // namespace
}  // namespace hystcan::migrate_command_test
