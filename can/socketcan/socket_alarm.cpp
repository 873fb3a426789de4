#include "can/socketcan/socket_alarm.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>
#include <system_error>

#include "base/error.h"

namespace hystcan::can {
namespace {

void end_waits(int /*signal*/, siginfo_t* info, void* /*context*/) {
  if (info->si_code != SI_TIMER) return;  // another process sent this signal
  const int error = errno;
  ::fcntl(info->si_value.sival_int, F_SETFL, O_RDWR | O_NONBLOCK);
  errno = error;
}

}  // namespace

SocketAlarm::SocketAlarm(int socket) : socket_(socket) {
  struct sigaction action {};
  action.sa_sigaction = end_waits;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  const int signal = SIGRTMAX - 1;  // valgrind needs SIGRTMAX
  if (::sigaction(signal, &action, nullptr) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot handle the signal of a timer");
  // A process inherits blocked signals; a blocked alarm would never end a wait.
  sigset_t alarm;
  ::sigemptyset(&alarm);
  ::sigaddset(&alarm, signal);
  ::pthread_sigmask(SIG_UNBLOCK, &alarm, nullptr);
  sigevent event{};
  event.sigev_notify = SIGEV_THREAD_ID;
  event.sigev_signo = signal;
  event.sigev_value.sival_int = socket;
  event._sigev_un._tid = ::gettid();
  if (::timer_create(CLOCK_MONOTONIC, &event, &timer_) != 0)
    throw RunError(std::string("cannot create a timer: ") + std::strerror(errno),
                   {.remedy = "raise ulimit -i (LimitSIGPENDING in a systemd unit)"});
}

SocketAlarm::~SocketAlarm() { ::timer_delete(timer_); }

void SocketAlarm::set(Time deadline) {
  deadline = std::max(deadline, Time{Duration{1}});  // zero would disarm the timer
  ::fcntl(socket_, F_SETFL, O_RDWR);
  const auto whole = std::chrono::floor<std::chrono::seconds>(deadline);
  itimerspec when{};
  when.it_value.tv_sec = whole.time_since_epoch().count();
  when.it_value.tv_nsec = (deadline - whole).count();
  ::timer_settime(timer_, TIMER_ABSTIME, &when, nullptr);
}

}  // namespace hystcan::can
