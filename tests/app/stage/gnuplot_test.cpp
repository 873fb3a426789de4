// Texts and names of strangers in gnuplot's scripts.
#include "app/stage/gnuplot.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <filesystem>
#include <regex>
#include <string>

namespace hystcan::app::gnuplot_test {
namespace {

/// One constant: quotes within are doubled, and no line ends.
bool is_one_string(const std::string& quoted) {
  return std::regex_match(quoted, std::regex("'(?:[^'\\x00-\\x1f]|'')*'"));
}

void holds(const std::function<void()>& property) { EXPECT_TRUE(rc::check(property)); }

TEST(Gnuplot, StringsEndWhereTheyShould) {
  holds([] {
    const auto text = *rc::gen::container<std::string>(rc::gen::weightedOneOf<char>(
        {{3, rc::gen::element('\'', '"', '\\', '\n', '`', '$', '{', '@')}, {1, rc::gen::arbitrary<char>()}}));
    RC_ASSERT(is_one_string(gnuplot_string(text)));
    RC_ASSERT(is_one_string(gnuplot_text(text)));
    RC_ASSERT(is_one_string(gnuplot_file(text)));
  });
}

TEST(Gnuplot, FileNamesStayInTheirFolderAndAreNotHidden) {
  holds([] {
    const std::string name = file_name_of(*rc::gen::arbitrary<std::string>());
    RC_ASSERT(std::regex_match(name, std::regex("[A-Za-z0-9_+][A-Za-z0-9_+.-]*")));
    RC_ASSERT(name == std::filesystem::path(name).filename());
  });
}

TEST(Gnuplot, TextIsShownAsItIs) {
  EXPECT_EQ(gnuplot_text("run_2026 10^{3} @a"), R"('run\_2026 10\^\{3\} \@a')");
  EXPECT_EQ(gnuplot_text("Sean's"), "'Sean''s'");
}

}  // namespace
}  // namespace hystcan::app::gnuplot_test
