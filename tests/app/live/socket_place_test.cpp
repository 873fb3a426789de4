#include "app/live/socket_place.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <array>
#include <cstdlib>
#include <optional>

#include "base/error.h"
#include "tests/support/shipped.h"

namespace hystcan::app::socket_place_test {
namespace {

/// Removes the variables that name a folder, as in a shell without a login.
class NoRuntimeVariables {
 public:
  NoRuntimeVariables() {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (const char* value = std::getenv(names[i])) values_[i] = value;
    for (const char* name : names) unsetenv(name);
  }
  ~NoRuntimeVariables() {
    for (std::size_t i = 0; i < names.size(); ++i) {
      unsetenv(names[i]);
      if (values_[i]) setenv(names[i], values_[i]->c_str(), 1);
    }
  }
  NoRuntimeVariables(const NoRuntimeVariables&) = delete;
  NoRuntimeVariables& operator=(const NoRuntimeVariables&) = delete;

 private:
  static constexpr std::array names{"RUNTIME_DIRECTORY", "XDG_RUNTIME_DIR"};
  std::array<std::optional<std::string>, 2> values_;
};

struct SocketPlace : testing::Test {
  NoRuntimeVariables none;
  support::ShippedCopy folder;
  SocketPlaces places{.runtime = folder / "run", .temporary = folder / "tmp", .service = folder / "service"};
  std::string uid = std::to_string(geteuid());
  std::filesystem::path in_runtime = places.runtime / uid / "hystcan-vcan0.sock";
  std::filesystem::path in_temporary = places.temporary / ("hystcan-" + uid) / "hystcan-vcan0.sock";

  void SetUp() override {
    std::filesystem::create_directory(places.runtime);
    std::filesystem::create_directory(places.temporary);
  }
  /// Creates a folder with this mode, for any umask.
  static void make(const std::filesystem::path& path, mode_t mode) {
    ASSERT_EQ(mkdir(path.c_str(), 0700), 0);
    ASSERT_EQ(chmod(path.c_str(), mode), 0);
  }
  static void make_socket(const std::filesystem::path& file) {
    const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    file.string().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << file;
    close(socket);
  }
  std::string refusal() const {
    try {
      return default_socket("vcan0", places).string();
    } catch (const RunError& error) {
      return error.what();
    }
  }
};

TEST_F(SocketPlace, IsTheFolderThatTheEnvironmentNames) {
  setenv("XDG_RUNTIME_DIR", "/of/login", 1);
  EXPECT_EQ(default_socket("can0", places), "/of/login/hystcan-can0.sock");
  setenv("RUNTIME_DIRECTORY", "/of/service", 1);
  EXPECT_EQ(default_socket("can0", places), "/of/service/hystcan-can0.sock");
}

TEST_F(SocketPlace, IsTheFirstOfSeveralFoldersOfAService) {
  setenv("RUNTIME_DIRECTORY", "/of/service:/of/service/too", 1);
  EXPECT_EQ(default_socket("can0", places), "/of/service/hystcan-can0.sock");
}

TEST_F(SocketPlace, IsTheRuntimeFolderOfTheUserIfThereIsOne) {
  make(places.runtime / uid, 0700);
  EXPECT_EQ(default_socket("vcan0", places), in_runtime);
  EXPECT_FALSE(std::filesystem::exists(in_temporary.parent_path()));
}

TEST_F(SocketPlace, IsAPrivateFolderByDefault) {
  EXPECT_EQ(default_socket("vcan0", places), in_temporary);
  struct stat found {};
  ASSERT_EQ(stat(in_temporary.parent_path().c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 07777U, 0700U);
  EXPECT_EQ(default_socket("vcan0", places), in_temporary) << "and used again";
}

TEST_F(SocketPlace, IsNeverAFolderInWhichOthersCanWrite) {
  make(places.runtime / uid, 0770);
  EXPECT_EQ(default_socket("vcan0", places), in_temporary);
  ASSERT_EQ(chmod(in_temporary.parent_path().c_str(), 0702), 0);
  EXPECT_NE(refusal().find("other users can write to the folder"), std::string::npos) << refusal();
  EXPECT_NE(refusal().find("control_socket"), std::string::npos) << refusal();
}

TEST_F(SocketPlace, IsNeverAFolderOfAnotherUser) {
  places.user = geteuid() + 1;
  const std::string name = "hystcan-" + std::to_string(places.user);
  make(places.temporary / name, 0700);
  EXPECT_NE(refusal().find("the folder belongs to user " + uid), std::string::npos) << refusal();
}

TEST_F(SocketPlace, IsNeverALinkOrAFile) {
  make(places.temporary / "elsewhere", 0700);
  std::filesystem::create_symlink(places.temporary / "elsewhere", in_temporary.parent_path());
  EXPECT_NE(refusal().find("the path is not a folder"), std::string::npos) << refusal();
  std::filesystem::remove(in_temporary.parent_path());
  std::ofstream(in_temporary.parent_path()).flush();
  EXPECT_NE(refusal().find("the path is not a folder"), std::string::npos) << refusal();
}

TEST_F(SocketPlace, IsTheSameForControllerAndClient) {
  EXPECT_EQ(find_socket("vcan0", places), default_socket("vcan0", places));
  make_socket(in_temporary);
  EXPECT_EQ(find_socket("vcan0", places), in_temporary);
  make(places.runtime / uid, 0700);
  EXPECT_EQ(find_socket("vcan0", places), in_temporary)
      << "the user has logged in since the controller's start";
  make_socket(in_runtime);
  EXPECT_EQ(find_socket("vcan0", places), in_runtime);
}

TEST_F(SocketPlace, FallsBackToTheSocketOfTheService) {
  make(places.service, 0750);
  make_socket(places.service / "hystcan-vcan0.sock");
  EXPECT_EQ(find_socket("vcan0", places), places.service / "hystcan-vcan0.sock");
  make_socket(find_socket("can0", places).parent_path() / "hystcan-vcan0.sock");
  EXPECT_EQ(find_socket("vcan0", places), in_temporary) << "the user's own goes first";
}

TEST_F(SocketPlace, FallsBackToThePageTokenOfTheService) {
  make(places.service, 0750);
  const std::filesystem::path of_service = places.service / "hystcan-vcan0.page-token";
  std::ofstream(of_service) << "of the service";
  EXPECT_EQ(find_page_token("vcan0", places), of_service);
  EXPECT_EQ(find_page_token("can0", places), in_temporary.parent_path() / "hystcan-can0.page-token");
  std::ofstream(in_temporary.parent_path() / "hystcan-vcan0.page-token") << "of the user";
  EXPECT_EQ(find_page_token("vcan0", places), in_temporary.parent_path() / "hystcan-vcan0.page-token");
}

TEST_F(SocketPlace, RefusesAFolderThatOthersCanWriteForAClient) {
  make(in_temporary.parent_path(), 0777);
  make_socket(in_temporary);
  EXPECT_THROW(find_socket("vcan0", places), RunError);
}

}  // namespace
}  // namespace hystcan::app::socket_place_test
