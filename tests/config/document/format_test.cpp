#include "config/document/format.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "base/error.h"
#include "base/input_file.h"
#include "config/document/document.h"
#include "config/files/model_file.h"
#include "config/schema/config.h"
#include "model/hysteresis.h"

namespace hystcan::config::format_test {
namespace {

const std::filesystem::path formats = HYSTCAN_SOURCE_DIR "/tests/config/formats";

std::filesystem::path file_of(int format, const char* name) {
  return formats / std::to_string(format) / name;
}

std::string text_of(const std::filesystem::path& file) { return read_regular_file(file, 1 << 20); }

std::string refusal_of(const std::string& text) {
  try {
    Document("stage.toml", text);
  } catch (const Error& error) {
    return error.what();
  }
  return "taken";
}

// Each folder has the files as a program of that format has written them.
TEST(Format, AFileOfEveryFormatBecomesThatOfTheNewest) {
  for (int format = 0; format <= newest_format; ++format)
    for (const char* name : {"stage.toml", "stage.model.toml", "stage.memory.toml"}) {
      const Migration migration = migrate(text_of(file_of(format, name)), name);
      EXPECT_EQ(migration.from, format) << name;
      EXPECT_EQ(migration.text, text_of(file_of(newest_format, name))) << format;
    }
}

TEST(Format, TheFilesOfTheNewestAreRead) {
  EXPECT_EQ(load(file_of(newest_format, "stage.toml")).axes.size(), 1U);
  const model::Hysteresis model(load_model(file_of(newest_format, "stage.model.toml")));
  EXPECT_EQ(load_memory(file_of(newest_format, "stage.memory.toml"), model, 100).depth(), 3U);
}

TEST(Format, AModelFileWithoutAFormatIsReadAsOneWithIt) {
  EXPECT_EQ(load_model(file_of(0, "stage.model.toml")).k_ascending,
            load_model(file_of(1, "stage.model.toml")).k_ascending);
}

TEST(Format, ANewerOneIsRefusedInOneSentence) {
  EXPECT_EQ(refusal_of("# of next year\nformat = 2\n[buses]\n"),
            "stage.toml:2:10: format is 2, written for a newer hystcan, expected at most 1");
}

TEST(Format, WhatIsNoNumberOfAFormatIsRefused) {
  for (const char* value : {"0", "-1", "1.0", "\"1\"", "[1]", "true"})
    EXPECT_EQ(refusal_of(std::string("format = ") + value + "\n"),
              "stage.toml:1:10: format is no number of a format, expected 1")
        << value;
}

TEST(Format, ATableThatHasGoneIsNamedWithTheWayOut) {
  EXPECT_EQ(refusal_of("[[axis]]\n[[axis]]\n[axis.control]\n[axis.control.adaptation]\ngain_max = 0.1\n"),
            "stage.toml:4:1: axis[1].control.adaptation no longer exists: it made the true error 2 to 7 % "
            "worse; `hystcan migrate stage.toml --write` comments it out");
}

TEST(Format, TheLineStandsBehindTheHeading) {
  const auto migrated = [](const char* text) { return migrate(text, "x").text; };
  EXPECT_EQ(migrated("# one\n# two\n\n[bus]\n"), "# one\n# two\n\nformat = 1\n\n[bus]\n");
  EXPECT_EQ(migrated("# one\n[bus]\n"), "# one\nformat = 1\n\n[bus]\n");
  EXPECT_EQ(migrated("[bus]\n"), "format = 1\n\n[bus]\n");
  EXPECT_EQ(migrated("key = 2\n"), "format = 1\nkey = 2\n");
  EXPECT_EQ(migrated("# one\r\n\r\n[bus]\r\n"), "# one\r\n\r\nformat = 1\r\n\r\n[bus]\r\n");
  EXPECT_EQ(migrated("\xEF\xBB\xBF[bus]\n"),
            "\xEF\xBB\xBF"
            "format = 1\n\n[bus]\n");
  EXPECT_EQ(migrated("# nothing else"), "# nothing else\n\nformat = 1\n");
  EXPECT_EQ(migrated(""), "format = 1\n");
}

TEST(Format, ASettingOnTheCommandLineHasNone) {
  EXPECT_THROW(load(HYSTCAN_SOURCE_DIR "/config/piezo.toml", {{"format", "1"}}), Error);
}

}  // namespace
}  // namespace hystcan::config::format_test
