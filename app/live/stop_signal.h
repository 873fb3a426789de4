// For commands that write a file and have no event loop: a signal ends them in good order, so that no
// unfinished file remains.
#pragma once

#include <csignal>

namespace hystcan::app {

inline volatile std::sig_atomic_t stop_signalled = 0;

/// After this call, Ctrl-C, SIGTERM and SIGHUP (unless it is ignored, as under nohup) only set
/// stop_signalled.
inline void stop_at_a_signal() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (std::signal(signal, [](int) { stop_signalled = 1; }) == SIG_IGN) std::signal(signal, SIG_IGN);
}

}  // namespace hystcan::app
