// Changes in the text of a TOML file: the changed and the unchanged text, and values without a place.
#include "config/document/toml_edit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "config/schema/config.h"
#include "tests/support/shipped.h"

namespace hystcan::config::toml_edit_test {
namespace {

std::string edited(const std::string& text, const std::string& path, const std::string& value) {
  TomlEdit edit(text, "f.toml");
  edit.set(path, value);
  return edit.text();
}

/// Returns the message of the Error, or "none".
std::string refusal_of(const std::string& text, const std::string& path, const std::string& value = "1.0") {
  TomlEdit edit(text, "f.toml");
  try {
    edit.set(path, value);
  } catch (const Error& error) {
    EXPECT_EQ(edit.text(), text) << "nothing is changed";
    return error.what();
  }
  return "none";
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(TomlEdit, ReplacesAValueAndKeepsItsComment) {
  EXPECT_EQ(edited("[a]\nk = 1.0 # of old\n", "a.k", "2.5"), "[a]\nk = 2.5 # of old\n");
}

TEST(TomlEdit, KeepsTheColumnOfACommentIfPossible) {
  EXPECT_EQ(edited("[a]\nk = 0.05     # c\n", "a.k", "1234.5"), "[a]\nk = 1234.5   # c\n");
  EXPECT_EQ(edited("[a]\nk = 0.05 # c\n", "a.k", "1234.5"), "[a]\nk = 1234.5 # c\n");
}

TEST(TomlEdit, KeepsLineEndsOfCarriageReturnAndLineFeed) {
  EXPECT_EQ(edited("[a]\r\nk = 1 # c\r\n", "a.k", "2"), "[a]\r\nk = 2 # c\r\n");
  EXPECT_EQ(edited("[a]\r\nk = 1\r\n\r\n[b]\r\n", "a.n", "2"), "[a]\r\nk = 1\r\nn = 2\r\n\r\n[b]\r\n");
}

TEST(TomlEdit, NeedsNoFinalNewline) {
  EXPECT_EQ(edited("[a]\nk = 1", "a.k", "2"), "[a]\nk = 2");
  EXPECT_EQ(edited("[a]\nk = 1", "a.n", "2"), "[a]\nk = 1\nn = 2");
  EXPECT_EQ(edited("[a]", "a.n", "2"), "[a]\nn = 2");
}

TEST(TomlEdit, CountsCharactersOutsideAsciiAsTheLibraryDoes) {
  EXPECT_EQ(edited("[a]\nk = { s = \"\xC2\xB5m\", n = 1 } # \xC2\xB5\n", "a.k.n", "22"),
            "[a]\nk = { s = \"\xC2\xB5m\", n = 22 } # \xC2\xB5\n");
}

TEST(TomlEdit, AddsAKeyBelowTheLastOneOfItsTableAndAlignsIt) {
  EXPECT_EQ(edited("[a]\nlong = 1   # c\nlist = [\n 1,\n 2]\n\n[a.b]\nk = 1\n", "a.n", "2"),
            "[a]\nlong = 1   # c\nlist = [\n 1,\n 2]\nn    = 2\n\n[a.b]\nk = 1\n");
  EXPECT_EQ(edited("[a]\nlong = 1\n", "a.n", "2"), "[a]\nlong = 1\nn    = 2\n");
}

TEST(TomlEdit, AddsATableBelowTheKeysOfTheTableAboveIt) {
  EXPECT_EQ(edited("[a]\nk = 1\n\n[a.b]\nx = 1\n", "a.c.n", "2"),
            "[a]\nk = 1\n\n[a.c]\nn = 2\n\n[a.b]\nx = 1\n");
}

TEST(TomlEdit, ChangesTheElementOfAListOfTables) {
  const std::string text = "[[axis]]\nk = 1\n[axis.c]\nx = 1\n[[axis]]\nk = 1\n[axis.c]\nx = 1\n";
  EXPECT_EQ(edited(text, "axis[1].k", "2"),
            "[[axis]]\nk = 1\n[axis.c]\nx = 1\n[[axis]]\nk = 2\n[axis.c]\nx = 1\n");
  EXPECT_EQ(edited(text, "axis[0].c.n.y", "2"),
            "[[axis]]\nk = 1\n[axis.c]\nx = 1\n\n[axis.c.n]\ny = 2\n[[axis]]\nk = 1\n[axis.c]\nx = 1\n");
}

TEST(TomlEdit, ReplacesValuesOfInlineTablesAndDottedKeys) {
  EXPECT_EQ(edited("[a]\nt = { k = 1, n = 2 }\n", "a.t.k", "3"), "[a]\nt = { k = 3, n = 2 }\n");
  EXPECT_EQ(edited("[a]\nt.k = 1\n", "a.t.k", "3"), "[a]\nt.k = 3\n");
}

TEST(TomlEdit, RefusesToAddAKeyToATableWithoutAHeader) {
  EXPECT_EQ(
      refusal_of("[a]\nt = { k = 1 }\n", "a.t.n"),
      "f.toml:2:5: a.t.n is missing, and a.t has no header line to add it below, expected a table [a.t]");
  EXPECT_NE(refusal_of("[a]\nt.k = 1\n", "a.t.n").find("expected a table [a.t]"), std::string::npos);
  EXPECT_NE(refusal_of("[a.t]\nk = 1\n", "a.n").find("expected a table [a]"), std::string::npos);
  EXPECT_NE(refusal_of("[a]\nk = 1\n", "a.k.n").find("the table that contains a.k.n is missing"),
            std::string::npos);
  EXPECT_NE(refusal_of("[[a]]\nk = 1\n", "a[1].k").find("the table that contains a[1].k is missing"),
            std::string::npos);
}

TEST(TomlEdit, RefusesAnInvalidValue) {
  EXPECT_NE(refusal_of("[a]\nk = 1\n", "a.k", "2\nn = 3").find("not a TOML value"), std::string::npos);
  EXPECT_NE(refusal_of("[a]\nk = 1\n", "a.k", "").find("expected TOML"), std::string::npos);
}

TEST(TomlEdit, CommentsATableOutAndLeavesTheRest) {
  TomlEdit edit("[a]\nk = 1\n\n[a.n]   # notch\nx = 1 # c\n\ny = 2\n\n[b]\n", "f.toml");
  edit.comment_out("a.n");
  EXPECT_EQ(edit.text(), "[a]\nk = 1\n\n# [a.n]   # notch\n# x = 1 # c\n\n# y = 2\n\n[b]\n");
  edit.comment_out("a.n");
}

TEST(TomlEdit, CommentsAKeyAndAnInlineTableOut) {
  TomlEdit edit("[a]\nk = 1\nn = { x = 1 }\n", "f.toml");
  edit.comment_out("a.k");
  edit.comment_out("a.n");
  EXPECT_EQ(edit.text(), "[a]\n# k = 1\n# n = { x = 1 }\n");
  TomlEdit within("[a]\nn = { x = 1 }\n", "f.toml");
  EXPECT_THROW(within.comment_out("a.n.x"), Error);
}

// The changes of `tune --write`, on each shipped configuration with axes.
TEST(TomlEdit, ChangesOnlyTheIntendedLinesOfAShippedConfiguration) {
  const support::ShippedCopy shipped;
  for (const char* name : {"piezo.toml", "p733.toml", "galfenol.toml"}) {
    const Config before = load(shipped / name);
    TomlEdit edit = TomlEdit::of_file(shipped / name);
    const std::string axis = before.axes.size() > 1 ? "axis[1]" : "axis[0]";
    edit.set(axis + ".control.ki_per_s", "201.5");
    edit.set(axis + ".control.delays.second_order", "true");
    for (const auto& [key, value] :
         {std::pair("frequency_Hz", "301.0"), std::pair("depth", "0.1"), std::pair("width", "0.5")})
      edit.set(axis + ".control.notch." + key, value);
    const std::vector<std::string> old = lines_of(support::read_file(shipped / name)),
                                   now = lines_of(edit.text());
    EXPECT_EQ(now.size(), old.size() + 6) << name << ": a key, a blank line, a header and its three keys";
    const auto unchanged = std::ranges::count_if(old, [&](const std::string& line) {
      return std::ranges::count(now, line) >= std::ranges::count(old, line);
    });
    EXPECT_GE(unchanged, static_cast<long>(old.size()) - 2) << name;
    std::ofstream(shipped / "new.toml", std::ios::binary) << edit.text();
    const Config after = load(shipped / "new.toml");
    EXPECT_EQ(after.axes.back().control.law.pi.ki_per_s, 201.5) << name;
    EXPECT_EQ(after.axes.back().control.law.notch->width, 0.5) << name;
    EXPECT_TRUE(after.axes.back().control.delays.second_order) << name;
    if (before.axes.size() > 1) {
      EXPECT_EQ(after.axes[0].control.law.pi.ki_per_s, before.axes[0].control.law.pi.ki_per_s);
    }
  }
}

TEST(TomlEdit, ReplacesTheCommentAfterAValue) {
  TomlEdit edit("[a]\nx = 1.0   # assumed\ny = 2 # two\nz = 3\n", "file.toml");
  edit.set_comment("a.x", "measured");
  edit.set_comment("a.z", "nothing to replace");
  edit.set_comment("a.w", "absent");
  EXPECT_EQ(edit.text(), "[a]\nx = 1.0   # measured\ny = 2 # two\nz = 3\n");
}

}  // namespace
}  // namespace hystcan::config::toml_edit_test
