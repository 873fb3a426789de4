// Texts that toml++ must not receive, because it would exhaust its stack or read beyond defined memory.
#include "config/document/toml_text.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "config/schema/config.h"
#include "config/schema/settings.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::toml_text_test {
namespace {

std::string repeated(const std::string& text, std::size_t times) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

/// `LINE:COLUMN: what`, or "none".
std::string refusal_of(const std::string& text) {
  const std::string refusal = support::refusal_of([&] { refuse_hostile_toml(text, "f"); });
  constexpr std::string_view before = "f:", behind = ", expected TOML";
  if (refusal == "accepted") return "none";
  return refusal.substr(before.size(), refusal.size() - before.size() - behind.size());
}

constexpr const char* not_in_a_string = "a character outside ASCII that is not in a string";

TEST(TomlText, RefusesADottedKeyOfManyPartsWithItsPlace) {
  const std::string fifteen = repeated("a.", 15);
  EXPECT_EQ(refusal_of(fifteen + "a = 1\n" + fifteen + "b = 2\n"), "none") << "sixteen parts";
  EXPECT_EQ(refusal_of("x = 1\n" + fifteen + "a.a = 1\n"), "2:32: a key of more than 16 parts");
  EXPECT_EQ(refusal_of("[" + repeated("a.", 60'000) + "a]"), "1:33: a key of more than 16 parts");
  EXPECT_EQ(refusal_of(repeated("\"a\" . ", 60'000) + "a = 1"), "1:95: a key of more than 16 parts");
}

TEST(TomlText, RefusesManyOpenBracketsWithTheirPlace) {
  EXPECT_EQ(refusal_of("a = " + repeated("[", 16) + repeated("]", 16)), "none");
  EXPECT_EQ(refusal_of("a = " + repeated("[", 17)), "1:21: more than 16 open brackets");
  EXPECT_EQ(refusal_of("a = " + repeated("{a = ", 50'000)), "1:85: more than 16 open brackets");
  EXPECT_EQ(refusal_of(repeated("[[a]]\nb = [1.5, 2.5, 3.5]\n", 1000)), "none") << "they are closed";
}

TEST(TomlText, RefusesNonAsciiCharactersOutsideStrings) {
  EXPECT_EQ(refusal_of("a = 1\n\xC2\xB5 = 2\n"), std::string("2:1: ") + not_in_a_string);
  EXPECT_EQ(refusal_of("a = \xC3\xA9\n"), std::string("1:5: ") + not_in_a_string);
  EXPECT_EQ(refusal_of("a = 1 \xC2\xA0\n"), std::string("1:7: ") + not_in_a_string) << "a hard space";
  EXPECT_EQ(refusal_of("a = \"b\"\xE2\x80\xA8"), std::string("1:8: ") + not_in_a_string);
}

TEST(TomlText, RefusesStringsThatTheLibraryMisreads) {
  EXPECT_EQ(refusal_of("a = \"\"\"\\\n\xC3\xA9\"\"\"\n"),
            "1:5: a multi-line string with a character outside ASCII");
  for (const char* text : {"a = 1\"\xC3\xA9\"", "a = 1='\xC3\xA9'", "a = -.'\xC3\xA9'",
                           "a = [1, 2['\xC3\xA9'", "a = 1979-05-27 07'\xC3\xA9'"})
    EXPECT_NE(refusal_of(text).find("a string directly after a number"), std::string::npos) << text;
}

TEST(TomlText, AcceptsAnyCharacterInStringsAndComments) {
  EXPECT_EQ(refusal_of("\xEF\xBB\xBF# \xC2\xB5m, [[[[[[[[[[[[[[[[[[[[[[[[\na = \"\xC2\xB5m\" # \xC3\xA9"),
            "none");
  EXPECT_EQ(refusal_of("a = '\xC2\xB5\\' # \xC2\xB5"), "none")
      << "a backslash ends a literal string like any letter";
  EXPECT_EQ(refusal_of("a = \"" + repeated("[.", 1000) + "\\\"" + repeated("[.", 1000) + "\""), "none");
  EXPECT_EQ(refusal_of("a = '''" + repeated("[.\n''", 1000) + "'''''\n"), "none");
  EXPECT_EQ(refusal_of("a2 = '\xC3\xA9'\nb=['\xC3\xA9','2']\nc.\"\xC3\xA9\" = {d='\xC3\xA9', e=1} #1'"),
            "none");
  EXPECT_EQ(refusal_of("a = \"\"\nb = ''\nc = \"\"\"\"\"\"\n[d.e]\n"), "none");
}

TEST(TomlText, FindsTheSameEndOfAStringAsTheLibrary) {
  const std::string deep = repeated("[", 17);
  EXPECT_NE(refusal_of("a = \"\"\"b\"\"\"\"\"\nc = " + deep), "none") << "two quotes before the three";
  EXPECT_NE(refusal_of("a = 'b\\'\nc = " + deep), "none");
  EXPECT_NE(refusal_of("a = \"b\\\\\"\nc = " + deep), "none");
  EXPECT_NE(refusal_of("a = \"not closed\nc = " + deep), "none");
}

struct HostileFile : testing::Test {
  support::ShippedCopy shipped;

  std::string refusal_of_load() const {
    return support::refusal_of<std::runtime_error>([this] { load(shipped / "piezo.toml"); });
  }
  /// Replaces the file by a pipe without a writer.
  void make_pipe(const char* name) const {
    std::filesystem::remove(shipped / name);
    ASSERT_EQ(mkfifo((shipped / name).c_str(), 0600), 0);
  }
  std::string path(const char* name) const { return (shipped / name).string(); }
};

TEST_F(HostileFile, IsRefusedForADeepKeyWithItsPlace) {
  for (const char* name : {"piezo.toml", "piezo.model.toml", "piezo.plant.toml"}) {
    const std::string text = support::read_file(shipped / name);
    std::ofstream(shipped / name) << repeated("a.", 60'000) << "a = 1\n";
    EXPECT_EQ(refusal_of_load(), path(name) + ":1:32: a key of more than 16 parts, expected TOML");
    std::ofstream(shipped / name) << text;
  }
}

TEST_F(HostileFile, IsRefusedIfLargerThanAMegabyte) {
  std::ofstream(shipped / "piezo.toml") << repeated("# remark\n", 120'000);
  EXPECT_EQ(
      refusal_of_load(),
      path("piezo.toml") + ": cannot be read: the file has more than 1048576 bytes, expected a TOML file");
}

TEST_F(HostileFile, IsRefusedAtOnceIfItIsAPipe) {
  make_pipe("hystcan.dbc");
  EXPECT_EQ(refusal_of_load(), path("hystcan.dbc") + ": cannot be read: the path names a pipe or a device");
  make_pipe("piezo.toml");
  EXPECT_EQ(refusal_of_load(),
            path("piezo.toml") + ": cannot be read: the path names a pipe or a device, expected a TOML file");
}

TEST_F(HostileFile, IsRefusedAtOnceIfASetpointNamesAPipe) {
  shipped.edit("piezo.toml", "kind         = \"triangle\"",
               "kind = \"csv\"\nfile = \"path.csv\"\n[[axis.control.setpoint]]\nkind = \"triangle\"");
  ASSERT_EQ(mkfifo((shipped / "path.csv").c_str(), 0600), 0);
  EXPECT_EQ(refusal_of_load(),
            path("path.csv") + ": cannot be read: the path names a pipe or a device, expected a CSV file");
}

TEST(TomlComment, IsValidForAnyText) {
  EXPECT_EQ(toml_comment("1/V\n[creep]\n"), "# 1/V\n# [creep]\n");
  const std::string comment = toml_comment("a\x1b[31m\tb\x7f \u00b5V\r\n");
  EXPECT_EQ(comment, "# a [31m b  \u00b5V \n");
  EXPECT_TRUE(parse_toml(comment + "a = 1\n", "text").contains("a"));
}

// The echo of a configuration passes its strings to the library a second time: settings() reads the
// configuration again from the output of a Writer.
TEST_F(HostileFile, MayContainADeepKeyInAString) {
  const std::string deep = "s\\\" " + repeated("a.", 60'000) + "a = \\\"";
  shipped.edit("piezo.toml", "[controller]\n", "[controller]\nstate_dir = \"" + deep + "\"\n");
  std::string read;
  for (const Setting& setting : settings(shipped / "piezo.toml"))
    if (setting.path == "controller.state_dir") read = setting.value;
  EXPECT_EQ(parse_toml("a = " + read, "read")["a"].value<std::string>(),
            "s\" " + repeated("a.", 60'000) + "a = \"");
}

TEST_F(HostileFile, IsRefusedForAControlCharacterInAString) {
  for (const char* character : {"\\n", "\\u001b", "\\u007f", "\t"}) {
    const support::ShippedCopy copy;
    copy.edit("piezo.toml", "name           = \"x\"", "name = \"x" + std::string(character) + "\"");
    EXPECT_THROW(load(copy / "piezo.toml"), Error) << character;
  }
}

}  // namespace
}  // namespace hystcan::config::toml_text_test
