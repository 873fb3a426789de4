// The client of `hystcan ctl`, and the age of the status that it shows.
#include "app/live/control_client.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <system_error>
#include <thread>

#include "app/live/cycle_outlets.h"
#include "tests/app/live/control_bench.h"

namespace hystcan::app::control_client_test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

const json status{{"do", "status"}};

std::errc failure_of(const std::filesystem::path& file, milliseconds limit = support::patience) {
  try {
    ask_socket(file, status, limit);
    return {};
  } catch (const std::system_error& error) {
    return static_cast<std::errc>(error.code().value());
  }
}

/// A socket whose process only listens and never answers.
class SilentSocket {
 public:
  explicit SilentSocket(const std::filesystem::path& file, int queue) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    file.string().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(socket_, queue), 0);
  }
  ~SilentSocket() { close(socket_); }
  SilentSocket(const SilentSocket&) = delete;
  SilentSocket& operator=(const SilentSocket&) = delete;

  int descriptor() const { return socket_; }

 private:
  int socket_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
};

TEST(ControlClient, ReturnsTheAnswerOfTheController) {
  const ControlBench bench;
  EXPECT_TRUE(is_ok(ask_socket(bench.socket(), status, std::nullopt)));
}

TEST(ControlClient, TimesOutWithoutAnAnswer) {
  const support::ShippedCopy folder;
  const SilentSocket socket(folder / "silent.sock", 10);
  EXPECT_EQ(failure_of(folder / "silent.sock", milliseconds(50)), std::errc::timed_out);
}

/// Answers the first connection with this text.
class Impostor {
 public:
  Impostor(const std::filesystem::path& file, std::string text)
      : listener_(file, 10), thread_([this, text = std::move(text)] { answer(text); }) {}

 private:
  void answer(const std::string& text) const {
    const int client = accept(listener_.descriptor(), nullptr, nullptr);
    for (std::size_t sent = 0; sent < text.size();) {
      const ssize_t now = send(client, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
      if (now < 0) break;
      sent += static_cast<std::size_t>(now);
    }
    close(client);
  }

  SilentSocket listener_;
  std::jthread thread_;
};

TEST(ControlClient, RefusesAnInvalidOrEndlessAnswer) {
  const support::ShippedCopy folder;
  const auto refusal_of = [&](const std::string& text) {
    std::filesystem::remove(folder / "false.sock");
    const Impostor impostor(folder / "false.sock", text);
    return failure_of(folder / "false.sock");
  };
  EXPECT_EQ(refusal_of("hello\n"), std::errc::bad_message);
  EXPECT_EQ(refusal_of("[1]\n"), std::errc::bad_message);
  EXPECT_EQ(refusal_of(std::string(100'000, '[') + "\n"), std::errc::bad_message);
  EXPECT_EQ(refusal_of(std::string(4'000'000, ' ')), std::errc::message_size);
}

TEST(ControlClient, TimesOutIfTheConnectionIsNotAccepted) {
  const support::ShippedCopy folder;
  const SilentSocket socket(folder / "silent.sock", 0);
  const Client first(folder / "silent.sock");
  EXPECT_EQ(failure_of(folder / "silent.sock", milliseconds(50)), std::errc::timed_out);
}

TEST(ControlClient, ReportsWhyTheSocketIsUnusable) {
  const support::ShippedCopy folder;
  EXPECT_EQ(failure_of(folder / "none.sock"), std::errc::no_such_file_or_directory);
  EXPECT_EQ(failure_of("/" + std::string(200, 'a')), std::errc::filename_too_long);
  EXPECT_EQ(failure_of(folder / "piezo.toml"), std::errc::connection_refused);
}

TEST(StatusBoard, ReportsTheAgeOfItsNewestRecord) {
  const StatusBoard::Clock::time_point start{};
  StatusBoard board(2, start);
  EXPECT_EQ(board.age_s(start + milliseconds(250)), 0.25) << "since the start, without a record";
  board.put({}, start + milliseconds(500));
  EXPECT_EQ(board.age_s(start + milliseconds(500)), 0.0);
  EXPECT_EQ(board.age_s(start + milliseconds(4500)), 4.0);
}

}  // namespace
}  // namespace hystcan::app::control_client_test
