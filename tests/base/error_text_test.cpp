// The user never sees the text of a library.
#include "base/error.h"

#include <gtest/gtest.h>

#include <boost/asio/error.hpp>
#include <boost/system/system_error.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace hystcan::app::error_text_test {
namespace {

std::string text_of_thrown(auto failing) {
  try {
    failing();
  } catch (const std::exception& error) {
    return error_text(error);
  }
  return "nothing was thrown";
}

TEST(ErrorText, AFileErrorIsTheFileAndTheReason) {
  EXPECT_EQ(text_of_thrown([] { (void)std::filesystem::file_size("/none/x"); }),
            "/none/x: No such file or directory");
}

TEST(ErrorText, AnErrorOfTheSystemIsItsReason) {
  EXPECT_EQ(text_of_thrown([] { throw std::system_error(EACCES, std::generic_category(), "/none/x"); }),
            "/none/x: Permission denied");
  EXPECT_EQ(
      text_of_thrown([] { throw boost::system::system_error(boost::asio::error::address_in_use, "bind"); }),
      "Address already in use");
}

TEST(ErrorText, MissingMemoryIsReported) {
  const std::string expected = "out of memory: the input is too large";
  EXPECT_EQ(text_of_thrown([] { throw std::bad_alloc(); }), expected);
  EXPECT_EQ(text_of_thrown([] { std::string().reserve(std::string().max_size() + 1); }), expected);
}

TEST(ErrorText, AThreadThatCannotBeStartedNamesTheLimit) {
  EXPECT_EQ(text_of_thrown([] {
              throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
            }),
            "cannot start another thread: raise the limit of processes (ulimit -u)");
}

TEST(ErrorText, AnInternalErrorIsMarkedAsSuch) {
  EXPECT_TRUE(text_of_thrown([] { (void)std::vector<int>().at(1); }).starts_with("a defect in hystcan ("));
}

TEST(ErrorText, InvalidJsonIsReported) {
  EXPECT_EQ(text_of_thrown([] { nlohmann::json().get<std::string>(); }),
            "invalid JSON, expected JSON as hystcan writes it");
}

TEST(ErrorText, AnErrorOfTheProjectKeepsItsText) {
  EXPECT_EQ(text_of_thrown([] { throw std::invalid_argument("gain is 0"); }), "gain is 0");
}

}  // namespace
}  // namespace hystcan::app::error_text_test
