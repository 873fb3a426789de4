// Requests to a running controller from another thread. The controller executes each complete request between
// two cycles and answers it once. Neither thread waits: two lock-free rings, one in each direction, carry
// pointers to requests. The requesting thread creates and frees the requests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "controller/control/axis.h"
#include "controller/wired_axis.h"

namespace hystcan::controller {

struct Request {
  enum class Kind : std::uint8_t {
    enable,   ///< bring the axis from offline to tracking
    disable,  ///< ramp to the safe drive, then switch off
    clear,    ///< clear the latched fault
    go_to,    ///< move from the configured reference to `position_um`
    resume,   ///< return to the configured reference
    retune,   ///< apply `tuning`; after that, `tuning` contains the previous tuning
    revert,   ///< discard the learnt corrections of a reference that repeats
    stop,     ///< stop all axes and the controller
  };
  Kind kind = Kind::enable;
  std::size_t axis = 0;
  double position_um = 0.0;
  std::unique_ptr<AxisTuning> tuning{};
  std::optional<Refusal> refusal{};  ///< the answer: why the request is refused; `nullopt`: accepted
  std::uint64_t cycle = 0;           ///< the last cycle before the request took effect
};

/// Carries requests from one thread to the control thread, and the answers back.
class RequestLink {
 public:
  RequestLink();
  RequestLink(const RequestLink&) = delete;
  RequestLink& operator=(const RequestLink&) = delete;
  ~RequestLink();

  /// Returns false if too many requests are unanswered; the request is then discarded.
  bool ask(std::unique_ptr<Request> request);
  /// Returns the oldest answer; null if there is none yet.
  std::unique_ptr<Request> take_answer();

  /// The control thread takes the next request (null if there is none), and returns it with its answer.
  /// Neither function allocates.
  Request* next();
  void answer(Request* request);

 private:
  struct Rings;  // keeps Boost's headers out of this header
  std::unique_ptr<Rings> rings_;
  std::size_t unanswered_ = 0;  ///< number of unanswered requests; used only by the requesting thread
};

/// Executes a request on the control thread, between two cycles.
std::optional<Refusal> carry_out(Request& request, WiredAxes& axes);

}  // namespace hystcan::controller
