// What may be asked of a running controller from another thread: answered once each, between two cycles, with
// nothing done by halves. Both ends are wait-free: two rings, one there and one back, of pointers that the
// asking side makes and frees.
#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include "controller/control/axis.h"

namespace hystcan::controller {

struct Request {
  enum class Kind : std::uint8_t {
    enable,   ///< towards tracking, from offline
    disable,  ///< ramp to the safe drive, switch off
    clear,    ///< forget the fault
    go_to,    ///< leave the configured reference for `position_um`
    resume,   ///< back to the configured reference
    retune,   ///< take `tuning` over; what was in force before is in its place then
    revert,   ///< forget the correction of the model learnt so far
    stop,     ///< every axis down, and an end of it all
  };
  Kind kind = Kind::enable;
  std::size_t axis = 0;
  double position_um = 0.0;
  std::unique_ptr<AxisTuning> tuning{};
  std::string_view refused_because{};  ///< the answer; empty: done
  std::uint64_t cycle = 0;             ///< the last one that knew nothing of it
};

/// One thread asks, one other (the control thread) answers.
class RequestLink {
 public:
  RequestLink() = default;
  RequestLink(const RequestLink&) = delete;
  RequestLink& operator=(const RequestLink&) = delete;
  ~RequestLink() {
    const auto free = [](Request* request) { delete request; };
    asked_.consume_all(free);
    answered_.consume_all(free);
  }

  /// False, and nothing asked: so many are unanswered already.
  bool ask(std::unique_ptr<Request> request) {
    if (pending_ == capacity || !asked_.push(request.get())) return false;
    static_cast<void>(request.release());  // the ring has it
    ++pending_;
    return true;
  }
  /// The oldest answer that is there; null: none yet.
  std::unique_ptr<Request> take_answer() {
    Request* request = nullptr;
    if (!answered_.pop(request)) return nullptr;
    --pending_;
    return std::unique_ptr<Request>(request);
  }

  /// On the control thread: the next one, null where there is none; then its answer, for which there is room.
  Request* next() {
    Request* request = nullptr;
    asked_.pop(request);
    return request;
  }
  void answer(Request* request) { answered_.push(request); }

 private:
  static constexpr std::size_t capacity = 64;
  using Ring = boost::lockfree::spsc_queue<Request*, boost::lockfree::capacity<capacity>>;

  Ring asked_;
  Ring answered_;
  std::size_t pending_ = 0;  ///< the asking side's own
};

}  // namespace hystcan::controller
