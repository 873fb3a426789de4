// The stream beside the control socket, as received by a program that follows only docs/control_socket.md.
#include "app/live/sample_stream.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <cstring>
#include <future>
#include <thread>

#include "tests/app/live/control_bench.h"
#include "tests/support/shipped.h"

namespace hystcan::app::sample_stream_test {
namespace {

using std::chrono::milliseconds;

class Listener {
 public:
  explicit Listener(const std::filesystem::path& socket) : socket_(connected_to(socket)) {}
  ~Listener() { ::close(socket_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  nlohmann::json greeting() {
    std::string line;
    for (char c = 0; read(&c, 1) && c != '\n';) line += c;
    columns_ = nlohmann::json::parse(line).at("columns").size();
    return nlohmann::json::parse(line);
  }
  struct Batch {
    std::vector<std::vector<double>> rows;
    std::uint32_t lost = 0;
    bool ended = false;
  };
  /// Returns true if the stream has closed the connection; earlier data may still be unread.
  bool is_closed() const {
    pollfd state{.fd = socket_, .events = POLLRDHUP, .revents = 0};
    return ::poll(&state, 1, 0) == 1;
  }
  Batch batch() {
    std::array<std::uint32_t, 2> head{};
    Batch batch;
    if (!read(head.data(), sizeof head)) {
      batch.ended = true;
      return batch;
    }
    batch.lost = head[1];
    batch.rows.assign(head[0], std::vector<double>(columns_));
    for (auto& row : batch.rows) read(row.data(), columns_ * sizeof(double));
    return batch;
  }

 private:
  bool read(void* to, std::size_t size) const {
    auto* bytes = static_cast<char*>(to);
    while (size > 0) {
      const ssize_t received = ::recv(socket_, bytes, size, 0);
      if (received <= 0) return false;
      bytes += received;
      size -= static_cast<std::size_t>(received);
    }
    return true;
  }

  int socket_;
  std::size_t columns_ = 0;
};

/// A stream of two columns.
class SampleStreamTest : public testing::Test {
 protected:
  SampleStreamTest()
      : stream_(std::make_unique<SampleStream>(context_, file(), R"({"columns":[{},{}]})", board_)),
        thread_([this] {
          const auto work = boost::asio::make_work_guard(context_);
          context_.run();
        }) {}
  ~SampleStreamTest() override {
    boost::asio::post(context_, [this] {
      stream_.reset();
      context_.stop();
    });
    thread_.join();
  }
  std::filesystem::path file() const { return folder_ / "samples.sock"; }
  void wait_for_a_listener() const {
    ASSERT_TRUE(support::eventually([&] { return board_.is_listening(); }));
  }
  /// Does the work on the stream's thread, which handles no batch before the work ends.
  void between_batches(const std::function<void()>& work) {
    std::promise<void> done;
    boost::asio::post(context_, [&] {
      work();
      done.set_value();
    });
    done.get_future().wait();
  }

  support::ShippedCopy folder_;
  boost::asio::io_context context_{1};
  SampleBoard board_{2, 1000};
  std::unique_ptr<SampleStream> stream_;
  std::thread thread_;
};

TEST_F(SampleStreamTest, GivesEveryRowInOrderToEachListener) {
  Listener one(file()), other(file());
  one.greeting();
  other.greeting();
  wait_for_a_listener();
  for (int i = 0; i < 100; ++i) board_.put(std::array{1.0 * i, -1.0 * i});
  for (Listener* listener : {&one, &other}) {
    int next = 0;
    while (next < 100)
      for (const std::vector<double>& row : listener->batch().rows) {
        EXPECT_EQ(row, (std::vector<double>{1.0 * next, -1.0 * next}));
        ++next;
      }
  }
}

TEST_F(SampleStreamTest, ReportsTheNumberOfDroppedRows) {
  Listener listener(file());
  listener.greeting();
  wait_for_a_listener();
  between_batches([&] {
    for (int i = 0; i < 5000; ++i) board_.put(std::array{1.0 * i, 0.0});
  });
  std::size_t rows = 0, lost = 0;
  while (rows + lost < 5000) {
    const Listener::Batch batch = listener.batch();
    rows += batch.rows.size();
    lost += batch.lost;
  }
  EXPECT_EQ(rows, 1000u) << "the places of the board";
  EXPECT_EQ(lost, 4000u);
}

TEST_F(SampleStreamTest, EndsWhileABatchIsDue) {
  Listener listener(file());
  listener.greeting();
  wait_for_a_listener();
  std::promise<void> ended;
  boost::asio::post(context_, [&] {
    // The next check of the timers finds the batch due, and queues it after the end of the stream. A longer
    // sleep has the same effect.
    std::this_thread::sleep_for(milliseconds(50));
    boost::asio::post(context_, [&] {
      stream_.reset();
      boost::asio::post(context_, [&] { boost::asio::post(context_, [&] { ended.set_value(); }); });
    });
  });
  ended.get_future().wait();
  EXPECT_FALSE(board_.is_listening());
}

TEST_F(SampleStreamTest, ClosesAListenerThatDoesNotReadAndServesTheOther) {
  Listener dead(file()), alive(file());
  alive.greeting();
  wait_for_a_listener();
  std::size_t rows = 0;
  EXPECT_TRUE(support::eventually([&] {
    for (int i = 0; i < 900; ++i) board_.put(std::array{1.0, 2.0});
    rows += alive.batch().rows.size();
    return dead.is_closed();
  }));
  EXPECT_GT(rows, 0u);
  EXPECT_FALSE(alive.batch().ended);
  dead.greeting();
  while (!dead.batch().ended) continue;  // the batches before the end
}

TEST_F(SampleStreamTest, CountsNoLostRowsWithoutAListener) {
  {
    Listener listener(file());
    listener.greeting();
    wait_for_a_listener();
  }
  ASSERT_TRUE(support::eventually([&] { return !board_.is_listening(); }));
  Listener later(file());
  EXPECT_EQ(later.greeting().at("columns").size(), 2u);
  EXPECT_EQ(later.batch().lost, 0u);
}

TEST_F(SampleStreamTest, RefusesAFifthListener) {
  std::vector<std::unique_ptr<Listener>> four;
  for (int i = 0; i < 4; ++i) {
    four.push_back(std::make_unique<Listener>(file()));
    four.back()->greeting();
  }
  Listener fifth(file());
  EXPECT_TRUE(fifth.batch().ended);
  EXPECT_FALSE(four.front()->batch().ended);
}

TEST(ControllerStream, GivesTheCyclesOfEachAxisBesideTheControlSocket) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, controller::AxisState::tracking));
  Listener listener(stream_beside(bench.socket()));
  const nlohmann::json greeting = listener.greeting();
  EXPECT_EQ(greeting.at("stream"), "controller");
  EXPECT_EQ(greeting.at("axes")[0].at("name"), "x");
  const auto column = [&](const char* name) {
    for (std::size_t i = 0; i < greeting.at("columns").size(); ++i)
      if (greeting.at("columns")[i].at("name") == name) return i;
    ADD_FAILURE() << name;
    return std::size_t{0};
  };
  const std::size_t axis = column("axis"), cycle = column("cycle"), state = column("state"),
                    reference = column("reference_um"), position = column("position_um");
  double last = 0.0;
  int rows = 0;
  // A busy machine may lose rows before and after the rows of a batch that reports lost ones.
  for (std::uint32_t lost_before = 0; rows < 500;) {
    const Listener::Batch batch = listener.batch();
    ASSERT_FALSE(batch.ended);
    bool is_next = last != 0.0 && lost_before == 0 && batch.lost == 0;
    lost_before = batch.lost;
    for (const std::vector<double>& row : batch.rows) {
      if (row[axis] != 0.0) continue;
      if (is_next) {
        EXPECT_EQ(row[cycle], last + 1.0);
      }
      is_next = true;
      last = row[cycle];
      EXPECT_EQ(greeting.at("states")[static_cast<std::size_t>(row[state])], "tracking");
      EXPECT_NEAR(row[position], row[reference], 1.0);
      ++rows;
    }
  }
}

}  // namespace
}  // namespace hystcan::app::sample_stream_test
