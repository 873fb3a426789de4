// A slow wire. The emulated cards send at once and refuse nothing. A token bucket in place of can0's queue
// passes one frame and then almost none, like a bus on which no node acknowledges. The kernel itself refuses
// the frames that do not fit.
#include <cerrno>
#include <string>

#include "can/socketcan/raw_socket.h"
#include "tests/can/socketcan/socketcan_fixture.h"
#include "tests/support/shows.h"

namespace hystcan::can::socketcan_queue_test {
namespace {

constexpr int frame_bytes = 16;  // the kernel's size of any frame

struct SocketCanControllerQueue : testing::Test {
  void SetUp() override {
    for (const char* name : {"can0", "can1"}) {
      const auto found = query_interface(name);
      if (!found || !found->up) GTEST_SKIP() << "there is no interface " << name << " that is up";
    }
  }
  void TearDown() override { shell("tc qdisc del dev can0 root"); }

  /// Passes one frame in 640 ms; `frames` more may wait.
  static void dam(int waiting_frames) {
    ASSERT_TRUE(shell("tc qdisc replace dev can0 root tbf rate 200bit burst 20 limit " +
                      std::to_string(waiting_frames * frame_bytes)));
  }
  /// Sends the waiting frames in their order.
  static void let_flow(int waiting_frames) {
    ASSERT_TRUE(shell("tc qdisc change dev can0 root tbf rate 1mbit burst 20 limit " +
                      std::to_string(waiting_frames * frame_bytes)));
  }
  /// The errno of each of ten successive writes to a socket with our options.
  static std::vector<int> ten_writes() {
    const int socket = open_raw_socket("can0", {});
    std::vector<int> errors;
    for (int i = 0; i < 10; ++i) errors.push_back(write_frame(socket, {.id = 0x201, .length = 8}));
    ::close(socket);
    return errors;
  }
  /// Sends frames 1..200 at once. The accepted frames arrive, then the last one, and no others.
  void sends_what_it_accepted_then_the_latest(int waiting_frames, std::size_t most_accepted);

  boost::asio::io_context context;
};

TEST_F(SocketCanControllerQueue, RefusesWithENOBUFSIfItIsFull) {
  dam(2);
  EXPECT_EQ(ten_writes(),
            (std::vector{0, 0, 0, ENOBUFS, ENOBUFS, ENOBUFS, ENOBUFS, ENOBUFS, ENOBUFS, ENOBUFS}));
}

TEST_F(SocketCanControllerQueue, RefusesWithEAGAINFromTheSendBufferIfItIsLong) {
  dam(1000);
  const std::vector<int> errors = ten_writes();
  EXPECT_EQ(errors.front(), 0);
  EXPECT_EQ(errors.back(), EAGAIN);
  for (const int error : errors) EXPECT_TRUE(error == 0 || error == EAGAIN) << error;
}

void SocketCanControllerQueue::sends_what_it_accepted_then_the_latest(int waiting_frames,
                                                                      std::size_t most_accepted) {
  SocketCanBus sender(context, "can0", {});
  SocketCanBus receiver(context, "can1", std::vector<Filter>{{0x201}});
  std::vector<std::uint8_t> heard;
  receiver.on_frame([&](const Frame& frame, Time) { heard.push_back(frame.data[0]); });
  dam(waiting_frames);
  std::vector<std::uint8_t> accepted;
  for (std::uint8_t i = 1; i <= 200; ++i)
    if (sender.send({.id = 0x201, .length = 1, .data = {i}})) accepted.push_back(i);
  EXPECT_GT(accepted.size(), 1U);
  EXPECT_LE(accepted.size(), most_accepted);
  EXPECT_EQ(sender.counters().send_refused, 200U - accepted.size());
  EXPECT_EQ(sender.state(), BusState::active) << "a full queue is not an error of the bus";
  let_flow(waiting_frames);
  run_until(context, [&] { return heard.size() >= accepted.size(); });
  EXPECT_TRUE(sender.send({.id = 0x201, .length = 1, .data = {0xFF}})) << "there is room again";
  accepted.push_back(0xFF);
  run_until(context, [&] { return heard.size() >= accepted.size(); });
  context.run_for(200ms);
  EXPECT_EQ(heard, accepted) << "a refused frame never arrives";
}

TEST_F(SocketCanControllerQueue, NeverSendsARefusedFrameLaterIfItIsFull) {
  shows("S-166");
  sends_what_it_accepted_then_the_latest(2, 3);
}

TEST_F(SocketCanControllerQueue, ContainsOnlyTheFramesOfTheSendBufferIfItIsLong) {
  sends_what_it_accepted_then_the_latest(1000, 9);
}

}  // namespace
}  // namespace hystcan::can::socketcan_queue_test
