// Handles signals for commands that write a file and have no event loop. A signal ends the command cleanly,
// so that no incomplete file remains.
#pragma once

#include <csignal>
#include <cstdint>
#include <functional>

#include "base/error.h"
#include "base/terminal.h"

namespace hystcan::app {

inline volatile std::sig_atomic_t stop_signalled = 0;

/// After this call, SIGINT (Ctrl-C), SIGTERM and SIGHUP only set stop_signalled. SIGINT is handled even if it
/// was ignored before: a shell script starts a background job (`hystcan excite ... &`) with SIGINT ignored,
/// and `kill -INT` must still end it. SIGHUP stays ignored if it was ignored before, as with nohup.
inline void stop_at_a_signal() {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (signal != SIGHUP || before != SIG_IGN) std::signal(signal, [](int) { stop_signalled = 1; });
}

/// Throws RunError if a signal has arrived.
inline void throw_if_signalled() {
  if (stop_signalled != 0) throw RunError("stopped, nothing is written");
}

/// Returns a function that an iterative search calls once per trial. The function shows the number of trials.
/// It returns false, which ends the search, after a signal.
inline std::function<bool()> counted_trials(Progress& progress) {
  return [&progress, tries = std::uint64_t{0}]() mutable {
    progress.update(++tries);
    return stop_signalled == 0;
  };
}

}  // namespace hystcan::app
