// More connections to the control socket than it serves: a `stop` is always executed.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <future>
#include <thread>
#include <vector>

#include "app/live/control_socket.h"
#include "tests/app/live/control_bench.h"

namespace hystcan::app::many_connections_test {
namespace {

using controller::AxisState;
using nlohmann::json;

constexpr std::size_t places = 16;

const json status{{"do", "status"}};
const json stop{{"do", "stop"}};

struct ManyConnections : testing::Test {
  ControlBench bench;
  std::vector<Client> clients;

  void SetUp() override { ASSERT_TRUE(bench.axis_is(0, AxisState::tracking)); }
  void connect(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) clients.push_back(bench.client());
  }
};

TEST_F(ManyConnections, AreDroppedIfIdleToAdmitAStop) {
  connect(300);
  EXPECT_TRUE(is_ok(bench.client().ask(stop)));
  EXPECT_TRUE(support::eventually([&] { return bench.asked_to_stop(); }));
}

TEST_F(ManyConnections, DropTheOldestIdleConnectionIfTheTableIsFull) {
  connect(places);
  for (Client& client : clients) ASSERT_TRUE(is_ok(client.ask(status)));
  ASSERT_TRUE(is_ok(clients[0].ask(status))) << "now the second one was silent longest";
  Client one_more = bench.client();
  EXPECT_TRUE(is_ok(one_more.ask(status)));
  EXPECT_TRUE(clients[1].read().is_null()) << "disconnected";
  EXPECT_TRUE(is_ok(clients[0].ask(status)));
  EXPECT_TRUE(is_ok(clients[2].ask(status)));
}

TEST_F(ManyConnections, DoNotDropTheWriter) {
  Client writer = bench.client();
  ASSERT_TRUE(is_ok(writer.ask({{"do", "go_to"}, {"axis", "x"}, {"position_um", 10.0}})));
  connect(3 * places);
  ASSERT_TRUE(is_ok(clients.back().ask(status)));
  EXPECT_TRUE(is_ok(writer.ask({{"do", "go_to"}, {"axis", "x"}, {"position_um", 11.0}})));
}

/// Answers every command at once, except `wait`, which it never answers.
class WaitsForever final : public CommandHandler {
 public:
  WaitsForever() : CommandHandler(Server::controller) {}
  void forget(const void*) override {}

  std::atomic<std::size_t> waiting{0};

 private:
  void carry_out(Verb verb, const json&, const Answer& answer) override {
    if (verb == Verb::wait)
      ++waiting;
    else
      answer({{"ok", true}});
  }
};

struct WaitingConnections : testing::Test {
  support::ShippedCopy folder;
  boost::asio::io_context context;
  WaitsForever handler;
  ControlSocket socket{context, folder / "control.sock", handler};
  std::vector<Client> clients;
  std::thread thread{[this] { context.run(); }};

  ~WaitingConnections() override {
    context.stop();
    thread.join();
  }
  Client client() const { return Client(folder / "control.sock"); }
  /// Returns the answer to a command that is sent before the socket accepts the connection: a connection in
  /// the last place has 100 ms for its command, and a busy machine may need longer.
  json ask_at_once(const json& command) {
    std::promise<void> sent;
    boost::asio::post(context, [&] { sent.get_future().wait(); });
    Client asking = client();
    asking.send(command.dump() + "\n");
    sent.set_value();
    return asking.read();
  }
  /// Every place is occupied by a connection that waits for an answer.
  void SetUp() override {
    for (std::size_t i = 0; i < places; ++i) {
      clients.push_back(client());
      clients.back().send("{\"do\": \"wait\"}\n");
    }
    ASSERT_TRUE(support::eventually([&] { return handler.waiting == places; }));
  }
};

TEST_F(WaitingConnections, AllowOneMoreThatMayOnlyStop) {
  EXPECT_TRUE(
      says(ask_at_once(status),
           "all 16 connections are in use, expected stop; for another command, close one of them and connect "
           "again"));
  EXPECT_TRUE(is_ok(ask_at_once(stop)));
}

TEST_F(WaitingConnections, DisconnectTheAdditionalOneIfItIsSilent) {
  EXPECT_TRUE(client().read().is_null()) << "disconnected";
  EXPECT_TRUE(is_ok(ask_at_once(stop))) << "the next one has its chance";
}

/// Allows no further file descriptors.
class FullTable {
 public:
  FullTable() {
    getrlimit(RLIMIT_NOFILE, &before_);
    const int lowest_free = dup(STDIN_FILENO);
    close(lowest_free);
    rlimit full = before_;
    full.rlim_cur = static_cast<rlim_t>(lowest_free);
    setrlimit(RLIMIT_NOFILE, &full);
  }
  ~FullTable() { setrlimit(RLIMIT_NOFILE, &before_); }
  FullTable(const FullTable&) = delete;
  FullTable& operator=(const FullTable&) = delete;

 private:
  rlimit before_{};
};

TEST(FileDescriptors, DoNotBlockTheServiceIfTheyAreExhausted) {
  const support::ShippedCopy folder;
  boost::asio::io_context context;
  WaitsForever handler;
  const ControlSocket socket(context, folder / "control.sock", handler);
  Client client(folder / "control.sock");
  {
    const FullTable full;
    EXPECT_LT(context.run_for(std::chrono::milliseconds(500)), 50u)
        << "handlers; a busy thread calls thousands, and a slow machine calls fewer";
  }
  client.send("{\"do\": \"status\"}\n");
  std::size_t handlers = 0;  // these are: waiting for the client, accepting it, its line, its answer
  while (handlers < 4) handlers += context.run_one();
  EXPECT_TRUE(is_ok(client.read()));
}

}  // namespace
}  // namespace hystcan::app::many_connections_test
