// Requests and their answers between two threads.
#include "controller/requests.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace hystcan::controller::request_link_test {
namespace {

constexpr std::size_t capacity = 64;

std::unique_ptr<Request> numbered(std::size_t number) {
  auto request = std::make_unique<Request>();
  request->kind = Request::Kind::go_to;
  request->axis = number;
  request->position_um = 0.5 * static_cast<double>(number);
  return request;
}

/// A control thread that answers one request in each poll, as the controller does in each cycle.
class ControlThread {
 public:
  explicit ControlThread(RequestLink& link)
      : thread_([this, &link] {
          while (!ending_) {
            Request* request = link.next();
            if (request == nullptr) {
              std::this_thread::yield();
              continue;
            }
            request->cycle = ++answered_;
            if (request->axis % 3 == 0) request->refusal = Refusal::not_enabled;
            link.answer(request);
          }
        }) {}
  ~ControlThread() {
    ending_ = true;
    thread_.join();
  }
  ControlThread(const ControlThread&) = delete;
  ControlThread& operator=(const ControlThread&) = delete;

 private:
  std::atomic<bool> ending_{false};
  std::uint64_t answered_ = 0;
  std::thread thread_;
};

// Bursts of any length, with answers taken at any time: none is lost or duplicated, and all arrive in order.
RC_GTEST_PROP(RequestLink, AnswersEveryRequestOnceAndInOrder, ()) {
  const auto bursts = *rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(1, 100));
  RequestLink link;
  const ControlThread control(link);
  std::size_t asked = 0;
  std::size_t answered = 0;
  const auto take = [&] {
    const auto request = link.take_answer();
    if (!request) return false;
    RC_ASSERT(request->axis == answered);
    RC_ASSERT(request->position_um == 0.5 * static_cast<double>(answered));
    RC_ASSERT(request->refusal.has_value() == (answered % 3 == 0));
    ++answered;
    RC_ASSERT(request->cycle == answered);
    return true;
  };
  for (const std::size_t burst : bursts) {
    for (std::size_t i = 0; i < burst; ++i) {
      while (!link.ask(numbered(asked)))  // the number of unanswered requests equals the capacity
        if (!take()) std::this_thread::yield();
      ++asked;
      RC_ASSERT(asked - answered <= capacity);
    }
    take();
  }
  while (answered < asked)
    if (!take()) std::this_thread::yield();
  RC_ASSERT(!link.take_answer());
}

TEST(RequestLink, RefusesRequestsBeyondItsCapacity) {
  RequestLink link;
  for (std::size_t i = 0; i < capacity; ++i) ASSERT_TRUE(link.ask(numbered(i)));
  EXPECT_FALSE(link.ask(numbered(capacity)));
  link.answer(link.next());
  EXPECT_FALSE(link.ask(numbered(capacity))) << "answered, but the answer is still in the ring";
  ASSERT_TRUE(link.take_answer());
  EXPECT_TRUE(link.ask(numbered(capacity)));
}

// The address sanitizer reports a leak as an error.
TEST(RequestLink, FreesUnreadAnswers) {
  RequestLink link;
  for (std::size_t i = 0; i < 10; ++i) ASSERT_TRUE(link.ask(numbered(i)));
  for (std::size_t i = 0; i < 4; ++i) link.answer(link.next());
  EXPECT_EQ(link.take_answer()->axis, 0u);
}

}  // namespace
}  // namespace hystcan::controller::request_link_test
