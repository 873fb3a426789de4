#include "app/live/realtime.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <thread>

extern "C" char end;  // the end of the program's own data, where the heap begins

namespace hystcan::app::realtime_test {
namespace {

/// Returns true if the address is in the heap that grows by brk(), the heap of the first thread of a process.
bool is_in_the_first_heap(const void* memory) { return memory > &end && memory < sbrk(0); }

bool another_thread_allocates_in_the_first_heap() {
  const void* memory = nullptr;
  std::thread([&] { memory = std::malloc(100); }).join();
  return is_in_the_first_heap(memory);
}

/// The heap belongs to the whole process: each case has its own process.
TEST(Heap, IsOneForAllThreadsIfShared) {
  const auto of_this_thread = std::make_unique<char>();
  if (!is_in_the_first_heap(of_this_thread.get()))
    GTEST_SKIP() << "this system has no heap that grows by brk()";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(_exit(another_thread_allocates_in_the_first_heap() ? 1 : 0), testing::ExitedWithCode(0), "");
  EXPECT_EXIT(
      {
        share_heap();
        _exit(another_thread_allocates_in_the_first_heap() ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace hystcan::app::realtime_test
