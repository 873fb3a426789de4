#include "app/command_line/pipeline.h"
#include "tests/support/refusal.h"

#include <gtest/gtest.h>

#include <pthread.h>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace hystcan::app {
namespace {

struct Numbered {
  int number = 0;
  int doubled = 0;
};

constexpr int many = 1000;

/// Numbers blocks from 1 to `many`; a negative `fails_at` never throws.
struct Source {
  int last = 0;
  int fails_at = -1;
  bool operator()(Numbered& block) {
    if (++last == fails_at) throw std::runtime_error("read");
    block.number = last;
    return last <= many;
  }
};

std::string error_of(int read_fails, int compute_fails, int write_fails) {
  const auto fail_at = [](int number, int at, const char* what) {
    if (number == at) throw std::runtime_error(what);
  };
  return support::refusal_of<std::runtime_error>([&] {
    run_pipeline<Numbered>(
        Source{.fails_at = read_fails},
        [&](Numbered& block) { fail_at(block.number, compute_fails, "compute"); },
        [&](const Numbered& block) { fail_at(block.number, write_fails, "write"); });
  });
}

TEST(Pipeline, PassesEachBlockOnceAndInOrder) {
  std::vector<int> written;
  run_pipeline<Numbered>(
      Source{}, [](Numbered& block) { block.doubled = 2 * block.number; },
      [&](const Numbered& block) { written.push_back(block.doubled); });
  ASSERT_EQ(written.size(), static_cast<std::size_t>(many));
  for (int i = 0; i < many; ++i) ASSERT_EQ(written[static_cast<std::size_t>(i)], 2 * (i + 1));
}

/// While this object exists, the system cannot allocate the stack of a new thread.
class NoFurtherThread {
 public:
  NoFurtherThread() {
    pthread_getattr_default_np(&before_);
    pthread_attr_t huge;
    pthread_attr_init(&huge);
    pthread_attr_setstacksize(&huge, std::size_t{1} << 50U);
    pthread_setattr_default_np(&huge);
    pthread_attr_destroy(&huge);
  }
  ~NoFurtherThread() { pthread_setattr_default_np(&before_); }
  NoFurtherThread(const NoFurtherThread&) = delete;
  NoFurtherThread& operator=(const NoFurtherThread&) = delete;

 private:
  pthread_attr_t before_{};
};

TEST(Pipeline, WorksWithoutFurtherThreads) {
  const NoFurtherThread none;
  ASSERT_THROW(std::thread([] {}).join(), std::system_error);
  int sum = 0;
  run_pipeline<Numbered>(
      Source{}, [](Numbered& block) { block.doubled = 2 * block.number; },
      [&](const Numbered& block) { sum += block.doubled; });
  EXPECT_EQ(sum, many * (many + 1));
  EXPECT_EQ(error_of(-1, 500, -1), "compute");
}

TEST(Pipeline, EndsWithTheErrorOfAnyStage) {
  EXPECT_EQ(error_of(-1, -1, -1), "accepted");
  EXPECT_EQ(error_of(500, -1, -1), "read");
  EXPECT_EQ(error_of(-1, 500, -1), "compute");
  EXPECT_EQ(error_of(-1, -1, 500), "write");
}

TEST(Pipeline, ReportsTheErrorOfTheEarliestBlock) {
  EXPECT_EQ(error_of(502, 501, 500), "write");
  EXPECT_EQ(error_of(502, 501, -1), "compute");
  EXPECT_EQ(error_of(501, 502, 503), "read");
}

TEST(Pipeline, WritesAllBlocksBeforeTheError) {
  int written = 0;
  EXPECT_THROW(run_pipeline<Numbered>(
                   Source{.fails_at = 500}, [](Numbered&) {}, [&](const Numbered&) { ++written; }),
               std::runtime_error);
  EXPECT_EQ(written, 499);
}

}  // namespace
}  // namespace hystcan::app
