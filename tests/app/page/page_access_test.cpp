#include "app/page/page_access.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::app::page_access_test {
namespace {

constexpr const char* token = "00112233445566778899aabbccddeeff";

unsigned judged(const std::string& host, const std::string& origin = "",
                const std::string& local = "127.0.0.1") {
  return PageAccess({"stage.lab"}, token)
      .judge({.method = "GET", .target = "/", .host = host, .origin = origin, .local_address = local})
      .status;
}

TEST(PageAccess, AcceptsTheNamesOfThisServerAtAnyPort) {
  for (const char* host :
       {"localhost", "LOCALHOST:8080", "127.0.0.1", "127.0.0.1:9000", "stage.lab", "Stage.Lab:8080"})
    EXPECT_EQ(judged(host), 200u) << host;
  EXPECT_EQ(judged("[::1]:8080", "", "::1"), 200u);
  EXPECT_EQ(judged("192.168.1.7:8080", "", "192.168.1.7"), 200u);
}

TEST(PageAccess, RefusesAnotherName) {
  for (const char* host :
       {"", "evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "192.168.1.8", "[::1]", "::1",
        "localhost:80:80", "[127.0.0.1", " localhost", "stage.lab."})
    EXPECT_EQ(judged(host), 421u) << host;
  EXPECT_EQ(judged("localhost", "", "192.168.1.7"), 421u) << "this address is not localhost";
}

TEST(PageAccess, RefusesAnotherOrigin) {
  EXPECT_EQ(judged("localhost:8080", "http://localhost:8080"), 200u);
  for (const char* origin :
       {"http://localhost", "http://localhost:8081", "https://localhost:8080", "null", "http://evil.example"})
    EXPECT_EQ(judged("localhost:8080", origin), 403u) << origin;
}

TEST(PageAccess, AcceptsOnlyItsToken) {
  const PageAccess access({}, token);
  EXPECT_TRUE(access.is_token(token));
  for (const std::string& wrong :
       {std::string(), std::string(token).substr(1), std::string(token) + "0", std::string(32, '0')})
    EXPECT_FALSE(access.is_token(wrong)) << wrong;
}

class TokenFile : public testing::Test {
 protected:
  std::string refused() const {
    return support::refusal_of<RunError>([this] { token_of(file_); });
  }
  bool is_refused_for(const std::string& reason) const { return refused().find(reason) != std::string::npos; }
  void write(const std::string& text, mode_t mode) const {
    std::ofstream(file_) << text;
    ::chmod(file_.c_str(), mode);
  }

  support::ShippedCopy folder_;
  std::filesystem::path file_ = folder_ / "page.token";
};

TEST_F(TokenFile, IsMadeForItsOwnerAloneAndKept) {
  const std::string first = token_of(file_);
  struct stat found {};
  ASSERT_EQ(::stat(file_.c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777U, 0600u);
  EXPECT_EQ(first.size(), 32u);
  EXPECT_EQ(token_of(file_), first);
  EXPECT_NE(new_token(), first);
}

TEST_F(TokenFile, IsRefusedIfOthersMayReadIt) {
  write(token, 0640);
  EXPECT_TRUE(is_refused_for("others can read it")) << refused();
}

TEST_F(TokenFile, IsRefusedIfItContainsNoToken) {
  for (const std::string& text :
       {std::string(), std::string("short"), std::string(32, 'x'), std::string(100, '0')}) {
    write(text, 0600);
    EXPECT_TRUE(is_refused_for("does not contain a token")) << text;
  }
}

TEST_F(TokenFile, RefusesALinkOrAFolder) {
  std::filesystem::create_symlink("piezo.toml", file_);
  EXPECT_TRUE(is_refused_for("cannot be read")) << refused();
  std::filesystem::remove(file_);
  std::filesystem::create_directory(file_);
  EXPECT_TRUE(is_refused_for("is not a file")) << refused();
}

}  // namespace
}  // namespace hystcan::app::page_access_test
