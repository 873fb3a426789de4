#include "app/live/exit_limit.h"

#include <unistd.h>

#include <string_view>
#include <system_error>
#include <thread>

#include "base/error.h"
#include "base/standard_streams.h"

namespace hystcan::app {

namespace {

void end_after(std::chrono::milliseconds limit) {
  std::this_thread::sleep_for(limit);
  std::string_view text = "hystcan: ended although files or streams were not written to the end\n";
  write_within(STDERR_FILENO, text, std::chrono::milliseconds(0));
  _exit(failed);
}

}  // namespace

ExitLimit::~ExitLimit() {
  try {
    std::thread(end_after, limit_).detach();
  } catch (const std::system_error&) {  // no thread: the end has no limit
    return;
  }
}

}  // namespace hystcan::app
