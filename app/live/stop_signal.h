// For commands that write a file and have no event loop: a signal ends them in good order, so that no
// unfinished file remains.
#pragma once

#include <csignal>

#include "base/error.h"

namespace hystcan::app {

inline volatile std::sig_atomic_t stop_signalled = 0;

/// After this call, Ctrl-C, SIGTERM and SIGHUP only set stop_signalled. A shell without job control starts a
/// background job (`hystcan excite ... &` in a script) with SIGINT ignored; `kill -INT` ends it all the same.
/// SIGHUP stays ignored if it is, as under nohup.
inline void stop_at_a_signal() {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (signal != SIGHUP || before != SIG_IGN) std::signal(signal, [](int) { stop_signalled = 1; });
}

/// Throws RunError.
inline void throw_if_signalled() {
  if (stop_signalled != 0) throw RunError("stopped, nothing is written");
}

/// After this call, SIGINT ends the process, also in a background job. For a command that waits for its
/// input.
inline void end_at_a_signal() { std::signal(SIGINT, SIG_DFL); }

}  // namespace hystcan::app
