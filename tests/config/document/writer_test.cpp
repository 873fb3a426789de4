// A Reader reads back the output of a Writer.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <fstream>

#include "config/document/document.h"
#include "tests/support/shipped.h"

namespace hystcan::config::writer_test {
namespace {

std::string read_back(const std::filesystem::path& file) {
  const Document document(file);
  Reader reader(document, document.root(), "");
  std::string value;
  reader.required("name", value);
  reader.finish();
  return value;
}

std::optional<std::string> without_comments(const Setting& /*key*/, bool /*is_required*/) { return ""; }

RC_GTEST_PROP(Writer, PrintsTextThatReadsBackTheSame, ()) {
  const support::ShippedCopy folder;
  const auto text = *rc::gen::nonEmpty(rc::gen::container<std::string>(
      rc::gen::oneOf(rc::gen::inRange<char>(' ', 127), rc::gen::element('"', '\\', '\'', '#'))));
  Writer writer(Writer::Layout::plain, without_comments);
  writer.required("name", text);
  std::ofstream(folder / "second.toml", std::ios::binary) << writer.text();
  RC_ASSERT(read_back(folder / "second.toml") == text);
}

TEST(Writer, PrintsPathsWithQuotesBackslashesAndCharactersOutsideAscii) {
  Writer writer(Writer::Layout::plain, without_comments);
  writer.required("name", std::filesystem::path("lab \"2\"/C:\\\xC2\xB5m"));
  EXPECT_EQ(writer.text(), "name = \"lab \\\"2\\\"/C:\\\\\xC2\xB5m\"\n");
}

}  // namespace
}  // namespace hystcan::config::writer_test
