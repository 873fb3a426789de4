#include "app/live/live_run.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <memory>
#include <string_view>
#include <system_error>
#include <thread>

#include "base/error.h"
#include "base/standard_streams.h"

namespace hystcan::app {

namespace {

bool has_terminal() {
  const int terminal = open("/dev/tty", O_RDONLY | O_NOCTTY | O_CLOEXEC);
  if (terminal < 0) return false;
  close(terminal);
  return true;
}

/// Returns true if this process ignores SIGHUP, for example because it was started with nohup.
bool ignores_hang_up() {
  struct sigaction action {};
  return sigaction(SIGHUP, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// Redirects standard streams to /dev/null if their terminal was closed. Without this, the report at the end
/// could not be printed and the run would fail.
void leave_terminal() {
  const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (isatty(stream) == 0 && errno == EIO) dup2(nowhere, stream);
  close(nowhere);
}

void end_after(std::chrono::milliseconds limit) {
  std::this_thread::sleep_for(limit);
  std::string_view text =
      "hystcan: ended with incomplete files or output, because a disk or a reader of the output did not "
      "respond\n";
  write_within(STDERR_FILENO, text, std::chrono::milliseconds(0));
  _exit(failed);
}

}  // namespace

bool terminal_hung_up() {
  static const bool depends_on_one = has_terminal() && !ignores_hang_up();
  return depends_on_one && !has_terminal();
}

void run_live(LiveLoop& loop, controller::Controller& controller, can::BusHealthLog& bus_log,
              const LiveRun& run) {
  constexpr auto check_period = std::chrono::milliseconds(20);
  terminal_hung_up();  // the first call stores whether the process has a terminal
  const can::Time start = loop.scheduler().now();
  bool stopping = false;
  const auto stop = [&] {
    stopping = true;
    if (run.before_stop) run.before_stop();
    controller.request_stop();
  };
  const auto must_stop = [&](can::Time now) {
    return controller.keeps_silent() || controller.asked_to_stop() || run.is_done(can::seconds(now - start));
  };
  std::unique_ptr<can::Timer> poll;
  poll = loop.scheduler().make_timer([&] {
    const can::Time now = loop.scheduler().now();
    bus_log.sample(can::report_of(controller.bus(), can::seconds(now - start)));
    if (stopping && controller.stopped()) return loop.stop();
    if (!stopping && must_stop(now)) stop();
    poll->expire_at(now + check_period);
  });
  controller.start(run.clear_faults);
  poll->expire_at(start + check_period);
  try {
    loop.run([&](int signal) {
      if (signal == SIGHUP && terminal_hung_up())
        leave_terminal();
      else if (signal == SIGHUP && run.reload)
        return run.reload();
      if (!stopping) return stop();
      // A second signal ends the ramp at once. SIGXCPU does not, because the kernel repeats it every second.
      if (signal != SIGXCPU) loop.stop();
    });
  } catch (...) {
    controller.send_safe_commands();
    throw;
  }
  controller.send_safe_commands();
}

ExitLimit::~ExitLimit() {
  try {
    std::thread(end_after, limit_).detach();
  } catch (const std::system_error&) {
    return;  // without a thread, the end of the process has no time limit
  }
}

}  // namespace hystcan::app
