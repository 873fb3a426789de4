#include "node/analogue/guard.h"

#include <poll.h>
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
#include <new>

#include "base/error.h"

namespace hystcan::node {
namespace {

void ignore_signals() {
  for (const int signal :
       {SIGINT, SIGTERM, SIGQUIT, SIGHUP, SIGPIPE, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1, SIGUSR2})
    std::signal(signal, SIG_IGN);
}

/// Requests the highest priority that this user may have, and locks memory in RAM. A refusal is not an error.
/// MCL_ONFAULT locks a page only when the guard first uses this page. Without MCL_ONFAULT, the guard would
/// get a locked copy of the whole memory of the node, and it would need milliseconds longer to end.
void request_highest_priority() {
  const sched_param priority{.sched_priority = sched_get_priority_max(SCHED_FIFO)};
  sched_setscheduler(0, SCHED_FIFO, &priority);
  mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT);
}

/// If the guard does not run for this time, the node kills the guard.
constexpr std::chrono::seconds unresponsive{1};

[[noreturn]] void fail() { throw RunError("cannot start the guard process", std::strerror(errno)); }

Guard::Duration now() { return std::chrono::steady_clock::now().time_since_epoch(); }

}  // namespace

Guard::Shared* Guard::held_by_this_thread() {
  void* const place =
      mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (place == MAP_FAILED) fail();
  auto* const shared = new (place) Shared;
  pthread_mutexattr_t kind;
  pthread_mutexattr_init(&kind);
  pthread_mutexattr_setpshared(&kind, PTHREAD_PROCESS_SHARED);
  pthread_mutexattr_setrobust(&kind, PTHREAD_MUTEX_ROBUST);
  pthread_mutex_init(&shared->life, &kind);
  pthread_mutexattr_destroy(&kind);
  pthread_mutex_lock(&shared->life);
  return shared;
}

bool Guard::ends(Shared& shared, Duration patience) {
  const Duration present = now(), due = Duration(shared.beat) + patience;
  const Duration until = due > present ? due : present + patience;
  const timespec deadline{.tv_sec = until / std::chrono::seconds(1),
                          .tv_nsec = (until % std::chrono::seconds(1)).count()};
  const bool is_over = pthread_mutex_clocklock(&shared.life, CLOCK_MONOTONIC, &deadline) != ETIMEDOUT;
  shared.watched = now().count();
  return is_over;
}

void Guard::watch(Shared& shared, int socket, const std::function<bool()>& make_safe, Duration patience) {
  prctl(PR_SET_NAME, "hystcan-guard");
  ignore_signals();
  request_highest_priority();
  make_safe();  // brings all memory that make_safe needs into RAM
  shared.watched = now().count();
  constexpr char ready = 'r';
  send(socket, &ready, 1, MSG_NOSIGNAL);
  while (!ends(shared, patience)) {
    const Duration beat{shared.beat};
    if (beat == Duration::zero() || now() - beat < patience) continue;
    ++shared.takeovers;
    make_safe();
  }
  _exit(make_safe() ? 0 : 1);
}

Guard::Guard(const std::function<bool()>& make_safe, Duration patience)
    : patience_(patience), shared_(held_by_this_thread()) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) fail();
  process_ = fork();
  if (process_ < 0) fail();
  if (process_ == 0) {
    close(ends[0]);
    watch(*shared_, ends[1], make_safe, patience);
  }
  close(ends[1]);
  socket_ = ends[0];
  char byte = 0;
  ssize_t count = -1;
  do count = recv(socket_, &byte, 1, 0);
  while (count < 0 && errno == EINTR);
  if (count != 1) throw RunError("cannot start the guard process", "the process ended before it was ready");
}

void Guard::beat() noexcept {
  const Duration present = now();
  shared_->beat = present.count();
  if (present - Duration(shared_->watched) > patience_ + unresponsive) kill(process_, SIGKILL);
}

bool Guard::abandon() noexcept {
  if (socket_ < 0) return false;
  pthread_mutex_unlock(&shared_->life);
  pollfd end{.fd = socket_, .events = POLLIN, .revents = 0};
  if (poll(&end, 1, std::chrono::milliseconds(unresponsive).count()) == 0) kill(process_, SIGKILL);
  int status = 0;
  const bool has_ended = waitpid(process_, &status, 0) == process_;
  close(socket_);
  socket_ = -1;
  pthread_mutex_destroy(&shared_->life);
  munmap(shared_, sizeof(Shared));
  return has_ended && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace hystcan::node
