// For commands that wait for nobody but write a file: a signal ends them in good order, so that what was
// written so far does not stay behind.
#pragma once

#include <csignal>

namespace hystcan::app {

inline volatile std::sig_atomic_t stop_signalled = 0;

/// From here on Ctrl-C, SIGTERM and a hang-up (unless ignored, as under nohup) only set stop_signalled.
inline void stop_at_a_signal() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (std::signal(signal, [](int) { stop_signalled = 1; }) == SIG_IGN) std::signal(signal, SIG_IGN);
}

}  // namespace hystcan::app
