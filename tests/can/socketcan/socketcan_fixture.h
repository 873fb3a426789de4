// Shared code of the tests of SocketCanBus on a real interface. Without CAN in the kernel they are skipped.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "can/socketcan/interface.h"
#include "can/socketcan/socketcan_bus.h"
#include "tests/support/patience.h"

namespace hystcan::can {

using namespace std::chrono_literals;

inline std::string reason_to_skip() {
  const int probe = ::socket(PF_CAN, SOCK_RAW, 1);
  if (probe < 0) return "this kernel has no AF_CAN";
  ::close(probe);
  const auto found = query_interface("vcan0");
  return found && found->up ? "" : "there is no interface vcan0 that is up";
}

inline bool shell(const std::string& command) { return std::system((command + " 2>/dev/null").c_str()) == 0; }

/// Runs handlers until `done` is true.
template <class Condition>
void run_until(boost::asio::io_context& context, Condition done) {
  const Time give_up = std::chrono::steady_clock::now() + support::patience;
  while (!done() && std::chrono::steady_clock::now() < give_up) context.run_one_for(100ms);
  context.restart();
  EXPECT_TRUE(done());
}

struct OnVcan : testing::Test {
  void SetUp() override {
    if (const std::string reason = reason_to_skip(); !reason.empty()) GTEST_SKIP() << reason;
  }

  std::unique_ptr<SocketCanBus> open(const std::string& interface, std::vector<Filter> filters) {
    auto bus = std::make_unique<SocketCanBus>(context, interface, filters);
    bus->on_frame([this](const Frame& frame, Time received) {
      heard.push_back(frame);
      stamps.push_back(received);
    });
    bus->on_state([this](BusState state) { states.push_back(state); });
    return bus;
  }

  template <class Condition>
  void run_until(Condition done) {
    hystcan::can::run_until(context, done);
  }

  boost::asio::io_context context;
  std::vector<Frame> heard;
  std::vector<Time> stamps;
  std::vector<BusState> states;
};
/// The test's own interface, which may be set down or deleted and which accepts FD frames.
struct SocketCanInterface : OnVcan {
  void SetUp() override {
    OnVcan::SetUp();
    if (IsSkipped()) return;
    if (!shell("ip link add dev vcan9 type vcan")) GTEST_SKIP() << "may not create an interface";
    ASSERT_TRUE(shell("ip link set vcan9 mtu 72 && ip link set vcan9 up"));
  }
  void TearDown() override { shell("ip link del vcan9"); }
};

}  // namespace hystcan::can
