#include "config/document/format.h"

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "config/document/document.h"
#include "config/schema/config.h"
#include "tests/support/refusal.h"

namespace hystcan::config::format_test {
namespace {

std::string refusal_of(const std::string& text) {
  return support::refusal_of([&] { Document("stage.toml", text); });
}

TEST(Format, IsTheFirstByDefault) { EXPECT_EQ(refusal_of("[bus]\n"), "accepted"); }

TEST(Format, RefusesANewerFormatInOneSentence) {
  EXPECT_EQ(refusal_of("# of next year\nformat = 2\n[buses]\n"),
            "stage.toml:2:10: format is 2, written for a newer hystcan, expected at most 1");
}

TEST(Format, RefusesAnInvalidFormatNumber) {
  for (const char* value : {"0", "-1", "1.0", "\"1\"", "[1]", "true"})
    EXPECT_EQ(refusal_of(std::string("format = ") + value + "\n"),
              "stage.toml:1:10: format is not a positive whole number, expected 1")
        << value;
}

TEST(Format, IsNotAllowedAsASettingOfTheCommandLine) {
  EXPECT_THROW(load(HYSTCAN_SOURCE_DIR "/config/piezo.toml", {{"format", "1"}}), Error);
}

}  // namespace
}  // namespace hystcan::config::format_test
