// docs/safety.md lists every cause.
#include <gtest/gtest.h>

#include <string>

#include "controller/control/fault.h"
#include "tests/support/shipped.h"

namespace hystcan::support::safety_table_test {
namespace {

TEST(SafetyTable, HasARowForEveryCause) {
  const std::string document = read_file(HYSTCAN_SOURCE_DIR "/docs/safety.md");
  for (std::size_t i = 1; i < controller::cause_count; ++i) {
    const std::string word(to_string(static_cast<controller::Cause>(i)));
    EXPECT_NE(document.find("\n| `" + word + "` |"), std::string::npos) << word;
  }
}

}  // namespace
}  // namespace hystcan::support::safety_table_test
