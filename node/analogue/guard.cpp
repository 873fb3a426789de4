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

#include "base/error.h"

namespace hystcan::node {
namespace {

void ignore_signals() {
  for (const int signal :
       {SIGINT, SIGTERM, SIGQUIT, SIGHUP, SIGPIPE, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1, SIGUSR2})
    std::signal(signal, SIG_IGN);
}

/// The best that this user may have; a refusal is no error. Pages are locked when they are used: to lock all
/// would copy those of the node, and the end of the guard would take milliseconds.
void hurry() {
  const sched_param priority{.sched_priority = sched_get_priority_max(SCHED_FIFO)};
  sched_setscheduler(0, SCHED_FIFO, &priority);
  mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT);
}

[[noreturn]] void fail() { throw RunError("no guard process", std::strerror(errno)); }

/// A robust lock that this thread has, in memory that a child shares.
pthread_mutex_t* held_lock() {
  void* const place =
      mmap(nullptr, sizeof(pthread_mutex_t), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (place == MAP_FAILED) fail();
  auto* const lock = static_cast<pthread_mutex_t*>(place);
  pthread_mutexattr_t kind;
  pthread_mutexattr_init(&kind);
  pthread_mutexattr_setpshared(&kind, PTHREAD_PROCESS_SHARED);
  pthread_mutexattr_setrobust(&kind, PTHREAD_MUTEX_ROBUST);
  pthread_mutex_init(lock, &kind);
  pthread_mutexattr_destroy(&kind);
  pthread_mutex_lock(lock);
  return lock;
}

[[noreturn]] void guard(pthread_mutex_t* life, int socket, const std::function<bool()>& make_safe) {
  prctl(PR_SET_NAME, "hystcan-guard");
  ignore_signals();
  hurry();
  make_safe();  // all that it uses is in memory now
  constexpr char ready = 'r';
  send(socket, &ready, 1, MSG_NOSIGNAL);
  pthread_mutex_lock(life);
  _exit(make_safe() ? 0 : 1);
}

}  // namespace

Guard::Guard(const std::function<bool()>& make_safe) : life_(held_lock()) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) fail();
  process_ = fork();
  if (process_ < 0) fail();
  if (process_ == 0) {
    close(ends[0]);
    guard(life_, ends[1], make_safe);
  }
  close(ends[1]);
  socket_ = ends[0];
  char byte = 0;
  ssize_t count = -1;
  do count = recv(socket_, &byte, 1, 0);
  while (count < 0 && errno == EINTR);
  if (count != 1) throw RunError("no guard process", "it has ended");
}

bool Guard::abandon() noexcept {
  if (socket_ < 0) return false;
  pthread_mutex_unlock(life_);
  int status = 0;
  const bool has_ended = waitpid(process_, &status, 0) == process_;
  close(socket_);
  socket_ = -1;
  pthread_mutex_destroy(life_);
  munmap(life_, sizeof(pthread_mutex_t));
  return has_ended && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace hystcan::node
