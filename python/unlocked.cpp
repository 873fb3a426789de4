#include "python/unlocked.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace hystcan::python {
namespace {

namespace py = pybind11;

std::atomic<bool> interpreter_ends{false};
std::thread::id ending_thread;  // written before interpreter_ends
std::atomic<int> unlocked_threads{0};

void stay_if_the_interpreter_ends() {
  if (!interpreter_ends || std::this_thread::get_id() == ending_thread) return;
  --unlocked_threads;
  while (true) pause();
}

/// Python calls this in the main thread, with the lock, before it ends the interpreter.
void wait_for_threads() {
  constexpr auto longest = std::chrono::seconds(30);  // the longest time between two calls of check_signals()
  const auto deadline = std::chrono::steady_clock::now() + longest;
  ending_thread = std::this_thread::get_id();
  interpreter_ends = true;
  const py::gil_scoped_release released;
  while (unlocked_threads > 0 && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

Unlocked::Unlocked() {
  ++unlocked_threads;
  thread_ = PyEval_SaveThread();
}

// The thread counts until it has the lock again: wait_for_threads() gives it the time.
Unlocked::~Unlocked() {
  stay_if_the_interpreter_ends();
  PyEval_RestoreThread(thread_);
  --unlocked_threads;
}

void check_signals() {
  stay_if_the_interpreter_ends();
  const py::gil_scoped_acquire python;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void bind_end_of_interpreter() {
  py::module_::import("atexit").attr("register")(py::cpp_function(&wait_for_threads));
}

}  // namespace hystcan::python
