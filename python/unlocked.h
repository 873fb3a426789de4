// Work without Python's lock that outlives neither a thread's interpreter nor its object.
#pragma once

#include <pybind11/pybind11.h>

namespace hystcan::python {

/// Releases Python's lock for a scope, in which no Python object is touched. A thread whose interpreter ends meanwhile
/// does not come back from the scope: Python would end it by an exception that C++ cannot pass on.
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* thread_;
};

/// Within such a scope: runs the handlers of Python's signals. Throws what they raise: KeyboardInterrupt at Ctrl-C.
void check_signals();

/// At the interpreter's end, waits until no other thread needs its lock.
void bind_end_of_interpreter();

}  // namespace hystcan::python
