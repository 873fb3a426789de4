#include "app/page/assets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

namespace hystcan::app::assets_test {
namespace {

const Asset* find(std::string_view path) {
  const auto assets = page_assets();
  const auto found = std::ranges::find(assets, path, &Asset::path);
  return found == assets.end() ? nullptr : &*found;
}

std::string content_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class PageAssets : public testing::Test {
 protected:
  void SetUp() override {
    if (!page_is_built()) GTEST_SKIP() << "built without npm, so without the page";
  }
};

TEST_F(PageAssets, AreTheFilesOfTheFolder) {
  for (const auto& entry : std::filesystem::directory_iterator(HYSTCAN_SOURCE_DIR "/app/page/web")) {
    const std::string name = entry.path().filename();
    if (entry.path().extension() == ".json") continue;  // for npm
    const auto* asset = find(name == "index.html" ? "/" : "/" + name);
    ASSERT_NE(asset, nullptr) << name;
    EXPECT_EQ(asset->content, content_of(entry.path())) << name;
  }
}

TEST_F(PageAssets, HaveTheTypeOfTheirEnding) {
  for (const auto& asset : page_assets()) {
    const auto expected = asset.path.ends_with(".js")    ? "text/javascript; charset=utf-8"
                          : asset.path.ends_with(".css") ? "text/css; charset=utf-8"
                          : asset.path.ends_with(".txt") ? "text/plain; charset=utf-8"
                                                         : "text/html; charset=utf-8";
    EXPECT_EQ(asset.type, expected) << asset.path;
  }
}

TEST_F(PageAssets, ContainEveryFileThatTheyName) {
  const std::regex reference(
      R"re((?:from\s+|import\s+|import\(|src=|href=)["']\.?(/?[A-Za-z_.-]+\.(?:js|css))["'])re");
  for (const auto& asset : page_assets()) {
    if (asset.path.starts_with("/uPlot")) continue;
    const std::string text(asset.content);
    for (std::sregex_iterator match(text.begin(), text.end(), reference), end; match != end; ++match) {
      const auto name = (*match)[1].str();
      EXPECT_NE(find(name.starts_with("/") ? name : "/" + name), nullptr) << asset.path << " names " << name;
    }
  }
}

TEST_F(PageAssets, HaveNoPathTwice) {
  std::set<std::string_view> paths;
  for (const auto& asset : page_assets()) EXPECT_TRUE(paths.insert(asset.path).second) << asset.path;
}

TEST_F(PageAssets, CarryTheLicenceOfUPlot) {
  const auto* licence = find("/uPlot.LICENSE.txt");
  ASSERT_NE(licence, nullptr);
  EXPECT_TRUE(licence->content.starts_with("The MIT License"));
  EXPECT_NE(find("/uPlot.esm.js"), nullptr);
  EXPECT_NE(find("/uPlot.min.css"), nullptr);
}

}  // namespace
}  // namespace hystcan::app::assets_test
