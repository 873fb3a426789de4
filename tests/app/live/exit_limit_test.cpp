#include "app/live/live_run.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>

namespace hystcan::app::exit_limit_test {
namespace {

void hang_after(std::chrono::milliseconds limit) {
  { const ExitLimit exit_limit(limit); }
  while (true) pause();
}

TEST(ExitLimit, EndsAProcessThatHangsWithOneLineAndStatusOne) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(hang_after(std::chrono::milliseconds(20)), testing::ExitedWithCode(1),
              "hystcan: ended although files or streams were not written to the end");
}

TEST(ExitLimit, DoesNotDelayAProcessThatEndsByItself) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto end = [] {
    { const ExitLimit exit_limit(std::chrono::hours(1)); }
    _exit(3);
  };
  EXPECT_EXIT(end(), testing::ExitedWithCode(3), "");
}

}  // namespace
}  // namespace hystcan::app::exit_limit_test
