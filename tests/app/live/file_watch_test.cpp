// The reported changes of a watched file.
#include "app/live/file_watch.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/patience.h"
#include "tests/support/scratch.h"

namespace hystcan::app::file_watch_test {
namespace {

class FileIsWatched : public testing::Test {
 protected:
  void watch(const std::filesystem::path& file) {
    watch_.emplace(context_, std::vector{file}, [this] {
      is_reported_ = true;
      context_.stop();
    });
    ASSERT_TRUE(watch_->is_watching());
  }
  bool reports() {
    is_reported_ = false;
    context_.restart();
    context_.run_for(support::patience);
    return is_reported_;
  }
  std::filesystem::path made(const char* name) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << "a = 1\n";
    return folder_ / name;
  }
  static void write(const std::filesystem::path& file) { std::ofstream(file) << "a = 2\n"; }
  /// Equals `ln --symbolic --force`.
  void lead(const char* link, const std::filesystem::path& target) const {
    std::filesystem::create_symlink(target, folder_ / "link.new");
    std::filesystem::rename(folder_ / "link.new", folder_ / link);
  }

  support::ScratchFolder folder_;

 private:
  boost::asio::io_context context_;
  std::optional<FileWatch> watch_;
  bool is_reported_ = false;
};

TEST_F(FileIsWatched, ThroughASymbolicLink) {
  const std::filesystem::path target = made("elsewhere/a.toml");
  std::filesystem::create_directory(folder_ / "between");
  lead("between/a.toml", "../elsewhere/a.toml");
  lead("a.toml", folder_ / "between/a.toml");
  watch(folder_ / "a.toml");
  write(target);
  EXPECT_TRUE(reports());
}

TEST_F(FileIsWatched, AfterItsLinkIsChanged) {
  lead("a.toml", made("one/a.toml"));
  watch(folder_ / "a.toml");
  const std::filesystem::path other = made("two/b.toml");
  lead("a.toml", other);
  EXPECT_TRUE(reports()) << "the link";
  write(other);
  EXPECT_TRUE(reports()) << "where it leads to now";
}

TEST_F(FileIsWatched, AfterACircleOfLinksIsBroken) {
  lead("a.toml", folder_ / "b.toml");
  lead("b.toml", folder_ / "a.toml");
  watch(folder_ / "a.toml");
  lead("b.toml", made("c.toml"));
  EXPECT_TRUE(reports());
}

}  // namespace
}  // namespace hystcan::app::file_watch_test
