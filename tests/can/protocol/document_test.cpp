// docs/protocol.md and docs/example_node.c refer to sections that exist.
#include <gtest/gtest.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace hystcan::can::document_test {
namespace {

std::string text_of(const std::string& file) {
  std::ifstream stream(HYSTCAN_SOURCE_DIR "/docs/" + file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The first group of each match.
std::vector<std::string> matches(const std::string& text, const char* pattern) {
  const std::regex regex(pattern, std::regex::ECMAScript | std::regex::multiline);
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it)
    found.push_back((*it)[1]);
  return found;
}

std::vector<std::string> sections() { return matches(text_of("protocol.md"), "^##+ ([^\\n]+)$"); }

/// As GitHub makes it: "A lab's own frames" has "a-labs-own-frames".
std::string anchor_of(const std::string& section) {
  std::string anchor;
  for (const char letter : section) {
    const auto code = static_cast<unsigned char>(letter);
    if (std::isalnum(code) != 0 || letter == '-') anchor += static_cast<char>(std::tolower(code));
    if (letter == ' ') anchor += '-';
  }
  return anchor;
}

TEST(ProtocolDocument, HasEverySectionThatTheReferenceNodeCites) {
  const std::vector<std::string> all = sections();
  const std::set<std::string> existing(all.begin(), all.end());
  const std::vector<std::string> cited = matches(text_of("example_node.c"), "// (?:---- )?\"([A-Z][^\"]+)\"");
  EXPECT_GT(cited.size(), 10u);
  for (const std::string& section : cited) EXPECT_TRUE(existing.contains(section)) << section;
}

TEST(ProtocolDocument, LinksOnlyToSectionsThatItHas) {
  std::set<std::string> anchors;
  for (const std::string& section : sections()) anchors.insert(anchor_of(section));
  const std::vector<std::string> links = matches(text_of("protocol.md"), "\\]\\(#([^)]+)\\)");
  EXPECT_GT(links.size(), 10u);
  for (const std::string& link : links) EXPECT_TRUE(anchors.contains(link)) << link;
}

}  // namespace
}  // namespace hystcan::can::document_test
