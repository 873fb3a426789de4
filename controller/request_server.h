// Carries out what is requested from outside through a RequestLink, on the control thread, between two
// cycles.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "controller/request_link.h"
#include "controller/wired_axis.h"

namespace hystcan::controller {

class RequestServer {
 public:
  explicit RequestServer(WiredAxes& axes) : axes_(axes) {}

  /// Before the first cycle. Without a link there are no requests.
  void listen_to(RequestLink& link) { link_ = &link; }
  /// Once in a cycle: answers the oldest request, if there is one. `cycle` goes into the answer.
  void answer_next(std::uint64_t cycle);
  /// A request asked for an end of the whole run.
  bool asked_to_stop() const { return asked_to_stop_; }

 private:
  /// Returns why the request is refused.
  std::optional<std::string_view> carry_out(Request& request);

  WiredAxes& axes_;
  RequestLink* link_ = nullptr;
  bool asked_to_stop_ = false;
};

}  // namespace hystcan::controller
