// The text of an error is composed of its parts.
#include "base/error.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace hystcan::error_test {
namespace {

const std::filesystem::path file = "stage/first.toml";

std::string text(const PlacedError& error) { return error.what(); }

TEST(ErrorParts, AnErrorWithoutAPlaceIsItsProblem) { EXPECT_EQ(text(Error("no axis")), "no axis"); }

TEST(ErrorParts, ThePlaceIsFirst) {
  EXPECT_EQ(text(Error(file, "no rows")), "stage/first.toml: no rows");
  EXPECT_EQ(text(Error({file, 3}, "no rows")), "stage/first.toml:3: no rows");
  EXPECT_EQ(text(Error({file, 3, 7}, "no rows")), "stage/first.toml:3:7: no rows");
  EXPECT_EQ(text(Error("--axis", "no rows")), "--axis: no rows");
}

TEST(ErrorParts, TheExpectedValueAndTheRemedyAreLast) {
  EXPECT_EQ(text(Error("no rows", expect("some"))), "no rows, expected some");
  EXPECT_EQ(text(Error("no rows", {.remedy = "record some"})), "no rows; record some");
  EXPECT_EQ(text(RunError({file, 1}, "no rows", {.expected = "some", .remedy = "record some"})),
            "stage/first.toml:1: no rows, expected some; record some");
}

TEST(ErrorParts, APlaceIsAddedToTheTextOfAnotherError) {
  EXPECT_EQ(
      text(Error(file, std::invalid_argument("gain is 0, expected > 0"), {.remedy = "nothing is written"})),
      "stage/first.toml: gain is 0, expected > 0; nothing is written");
  EXPECT_EQ(text(Error("no save", Error({file, 3}, "no rows"))), "no save: stage/first.toml:3: no rows");
}

TEST(ErrorParts, ARemedyIsAddedAfterThePlace) {
  EXPECT_EQ(text(RunError({}, RunError({file, 3}, "no rows"), {.remedy = "record some"})),
            "stage/first.toml:3: no rows; record some");
}

TEST(ErrorParts, ASentenceIsTheLastPart) {
  RunError error(file, "no rows", expect("some"));
  error.add_sentence("The folder is kept");
  EXPECT_EQ(text(error), "stage/first.toml: no rows, expected some. The folder is kept");
}

TEST(ErrorParts, AFileGetsItsNameInTheNewFolder) {
  const auto renamed = [](const char* name) {
    Error error({name, 3}, ".stage.x is wrong");
    error.rename_folder(".stage.x", "stage");
    return text(error);
  };
  EXPECT_EQ(renamed(".stage.x/first.toml"), "stage/first.toml:3: .stage.x is wrong");
  EXPECT_EQ(renamed(".stage.x"), "stage:3: .stage.x is wrong");
  EXPECT_EQ(renamed(".stage.xyz/first.toml"), ".stage.xyz/first.toml:3: .stage.x is wrong");
}

TEST(ErrorParts, AControlCharacterBecomesASpace) {
  EXPECT_EQ(text(Error("a\nb", "c\x1b[0m\td", expect("e\rf"))), "a b: c [0m d, expected e f");
}

}  // namespace
}  // namespace hystcan::error_test
