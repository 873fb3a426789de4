// Compares docs/safety.md with the sources: it names every cause, and every test that it names exists.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include "controller/control/fault.h"
#include "tests/support/fault_rig.h"

namespace hystcan::support::safety_table_test {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

const std::string& document() {
  static const std::string text = text_of(HYSTCAN_SOURCE_DIR "/docs/safety.md");
  return text;
}

/// The sources of the tests, one after the other.
const std::string& sources() {
  static const std::string all = [] {
    std::string text;
    for (const char* folder : {"/tests/safety", "/tests/controller", "/tests/closed_loop", "/tests/hil"})
      for (const auto& entry : std::filesystem::directory_iterator(HYSTCAN_SOURCE_DIR + std::string(folder)))
        if (entry.path().extension() == ".cpp") text += text_of(entry.path());
    return text;
  }();
  return all;
}

bool is_trouble(const std::string& name) {
  for (std::size_t i = 0; i < trouble_count; ++i)
    if (to_string(static_cast<Trouble>(i)) == name) return true;
  return false;
}

TEST(SafetyTable, HasARowForEveryCause) {
  for (std::size_t i = 1; i < controller::cause_count; ++i) {
    const std::string word(to_string(static_cast<controller::Cause>(i)));
    EXPECT_NE(document().find("\n| `" + word + "` |"), std::string::npos) << word;
  }
}

TEST(SafetyTable, NamesOnlyTestsThatExist) {
  const std::regex test_name("`([A-Z][A-Za-z]+)\\.([A-Z][A-Za-z]+)`");
  const std::string& text = document();
  std::size_t named = 0;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), test_name); it != std::sregex_iterator();
       ++it) {
    ++named;
    const std::regex definition("TEST(_F|_P)?\\(" + (*it)[1].str() + ",\\s+" + (*it)[2].str() + "\\)");
    EXPECT_TRUE(std::regex_search(sources(), definition)) << (*it)[0];
  }
  EXPECT_GE(named, 8u) << "the document has been read";
}

TEST(SafetyTable, NamesEveryTroubleThatIsInjected) {
  const std::regex injected("`Fault/([a-z_]+)`");
  const std::string& text = document();
  for (auto it = std::sregex_iterator(text.begin(), text.end(), injected); it != std::sregex_iterator(); ++it)
    EXPECT_TRUE(is_trouble((*it)[1])) << (*it)[1];
  for (std::size_t i = 0; i < trouble_count; ++i) {
    const std::string name(to_string(static_cast<Trouble>(i)));
    EXPECT_NE(text.find("`Fault/" + name + "`"), std::string::npos) << name;
    EXPECT_NE(sources().find("{Trouble::" + name + ", Cause::"), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace hystcan::support::safety_table_test
