// For commands that write a file and have no event loop: a signal ends them cleanly, so that no incomplete
// file remains.
#pragma once

#include <csignal>
#include <cstdint>
#include <functional>

#include "base/error.h"
#include "base/terminal.h"

namespace hystcan::app {

inline volatile std::sig_atomic_t stop_signalled = 0;

/// After this call, Ctrl-C, SIGTERM and SIGHUP only set stop_signalled. SIGINT is handled even if it was
/// ignored: a shell without job control starts a background job (`hystcan excite ... &` in a script) with
/// SIGINT ignored, and `kill -INT` must still end it. SIGHUP stays ignored if it was, as under nohup.
inline void stop_at_a_signal() {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (signal != SIGHUP || before != SIG_IGN) std::signal(signal, [](int) { stop_signalled = 1; });
}

/// Throws RunError after a signal.
inline void throw_if_signalled() {
  if (stop_signalled != 0) throw RunError("stopped, nothing is written");
}

/// Returns a function for a search that continues while the function returns true: shows the number of
/// trials, and ends the search at a signal.
inline std::function<bool()> counted_trials(Progress& progress) {
  return [&progress, tries = std::uint64_t{0}]() mutable {
    progress.update(++tries);
    return stop_signalled == 0;
  };
}

}  // namespace hystcan::app
