// The main function of the test programs. Exit status: 0 passed, 1 failed, 77 passed but with skipped tests,
// which ctest shows as skipped (SKIP_RETURN_CODE). Property tests draw HYSTCAN_CASES cases, 100 by default,
// the same on every run; RC_PARAMS in the environment overrides this.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

/// Prints, for example, "passed Storm.Ends: S-012, S-034": the promises that a test shows
/// (tests/support/shows.h), even if only failures are printed.
class Promises : public testing::EmptyTestEventListener {
  void OnTestEnd(const testing::TestInfo& test) override {
    const testing::TestResult& result = *test.result();
    const char* verdict = result.Failed() ? "failed" : result.Skipped() ? "skipped" : "passed";
    for (int i = 0; i < result.test_property_count(); ++i)
      if (const testing::TestProperty& property = result.GetTestProperty(i);
          property.key() == std::string("shows"))
        std::printf("%s %s.%s: %s\n", verdict, test.test_suite_name(), test.name(), property.value());
  }
};

}  // namespace

int main(int argc, char** argv) {
  const char* cases = std::getenv("HYSTCAN_CASES");
  const std::string drawn = std::string("seed=20261121 max_success=") + (cases != nullptr ? cases : "100");
  setenv("RC_PARAMS", drawn.c_str(), 0);
  testing::InitGoogleTest(&argc, argv);
  testing::UnitTest::GetInstance()->listeners().Append(new Promises);
  const int status = RUN_ALL_TESTS();
  const bool skipped = testing::UnitTest::GetInstance()->skipped_test_count() > 0;
  return status == 0 && skipped ? 77 : status;
}
