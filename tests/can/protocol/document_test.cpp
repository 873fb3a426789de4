// The reference node cites only sections of docs/protocol/*.md that exist.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace hystcan::can::document_test {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Returns the first group of each match.
std::vector<std::string> matches(const std::string& text, const char* pattern) {
  const std::regex regex(pattern, std::regex::ECMAScript | std::regex::multiline);
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it)
    found.push_back((*it)[1]);
  return found;
}

/// Joins the lines of each comment, so that a title can continue in the next line.
std::string in_one_line(const std::string& text) {
  return std::regex_replace(text, std::regex("\n *///? "), " ");
}

std::set<std::string> sections() {
  std::set<std::string> all;
  for (const auto& page : std::filesystem::directory_iterator(HYSTCAN_SOURCE_DIR "/docs/protocol"))
    for (const std::string& section : matches(text_of(page.path()), "^##+ ([^\\n]+)$")) all.insert(section);
  return all;
}

TEST(ProtocolDocument, HasEverySectionThatTheReferenceNodeCites) {
  const std::set<std::string> existing = sections();
  std::vector<std::string> cited;
  for (const auto& file : std::filesystem::directory_iterator(HYSTCAN_SOURCE_DIR "/node/firmware"))
    for (const std::string& section : matches(in_one_line(text_of(file.path())), "\\.md, \"([A-Z][^\"]+)\""))
      cited.push_back(section);
  EXPECT_GT(cited.size(), 10u);
  for (const std::string& section : cited) EXPECT_TRUE(existing.contains(section)) << section;
}

}  // namespace
}  // namespace hystcan::can::document_test
