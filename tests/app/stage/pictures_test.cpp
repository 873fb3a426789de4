// Foreign names as file names.
#include "app/stage/pictures.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <filesystem>
#include <regex>
#include <string>

namespace hystcan::app::pictures_test {
namespace {

TEST(Pictures, FileNamesStayInTheirFolderAndAreNotHidden) {
  EXPECT_TRUE(rc::check([] {
    const std::string name = file_name_of(*rc::gen::arbitrary<std::string>());
    RC_ASSERT(std::regex_match(name, std::regex("[A-Za-z0-9_+][A-Za-z0-9_+.-]*")));
    RC_ASSERT(name == std::filesystem::path(name).filename());
  }));
}

}  // namespace
}  // namespace hystcan::app::pictures_test
