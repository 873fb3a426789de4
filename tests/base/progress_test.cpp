// The progress bar fits the width of the terminal.
#include "base/terminal.h"

#include <gtest/gtest.h>

#include <string>

namespace hystcan::app::progress_test {
namespace {

const std::string rest = " 50 %  1000 rows, 12 s left";

TEST(ProgressLine, HasABarOfThirtyCharactersOnAWideTerminal) {
  EXPECT_EQ(progress_line("simulating", 0.5, rest, 200),
            "simulating [" + std::string(15, '=') + std::string(15, ' ') + "] " + rest);
}

TEST(ProgressLine, IsNarrowerThanTheTerminal) {
  for (std::size_t columns = 1; columns <= 200; ++columns)
    for (const double share : {0.0, 0.3, 1.0})
      EXPECT_LT(progress_line("simulating", share, rest, columns).size(), columns) << columns;
}

TEST(ProgressLine, UsesTheWidthUpToTheLastColumnButOne) {
  for (std::size_t columns = 50; columns <= 70; ++columns)
    EXPECT_EQ(progress_line("simulating", 0.3, rest, columns).size(), columns - 1);
}

TEST(ProgressLine, HasNoBarOnANarrowTerminal) {
  EXPECT_EQ(progress_line("simulating", 0.5, rest, 42), "simulating " + rest);
}

}  // namespace
}  // namespace hystcan::app::progress_test
