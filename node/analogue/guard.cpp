#include "node/analogue/guard.h"

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>

#include "base/error.h"

namespace hystcan::node {
namespace {

void ignore_signals() {
  for (const int signal :
       {SIGINT, SIGTERM, SIGQUIT, SIGHUP, SIGPIPE, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1, SIGUSR2})
    std::signal(signal, SIG_IGN);
}

/// The best that this user may have; a refusal is no error.
void hurry() {
  const sched_param priority{.sched_priority = sched_get_priority_max(SCHED_FIFO)};
  sched_setscheduler(0, SCHED_FIFO, &priority);
  mlockall(MCL_CURRENT | MCL_FUTURE);
}

/// Waits for a byte; false: the other end is closed.
bool receive(int socket) {
  char byte = 0;
  ssize_t count = -1;
  do count = recv(socket, &byte, 1, 0);
  while (count < 0 && errno == EINTR);
  return count == 1;
}

[[noreturn]] void guard(int socket, const std::function<bool()>& make_safe) {
  prctl(PR_SET_NAME, "hystcan-guard");
  ignore_signals();
  hurry();
  constexpr char ready = 'r';
  send(socket, &ready, 1, MSG_NOSIGNAL);
  receive(socket);
  _exit(make_safe() ? 0 : 1);
}

}  // namespace

Guard::Guard(const std::function<bool()>& make_safe) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw RunError(std::string("no guard process: ") + std::strerror(errno));
  process_ = fork();
  if (process_ < 0) throw RunError(std::string("no guard process: ") + std::strerror(errno));
  if (process_ == 0) {
    close(ends[0]);
    guard(ends[1], make_safe);
  }
  close(ends[1]);
  socket_ = ends[0];
  if (!receive(socket_)) throw RunError("no guard process: it has ended");
}

bool Guard::abandon() noexcept {
  if (socket_ < 0) return false;
  close(socket_);
  socket_ = -1;
  int status = 0;
  return waitpid(process_, &status, 0) == process_ && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace hystcan::node
