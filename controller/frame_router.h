// Passes each received frame to the handler of its identifier. The routes are added once; a lookup is a
// binary search and allocates nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "can/bus.h"

namespace hystcan::controller {

class FrameRouter {
 public:
  using Handler = std::function<void(const can::Frame& frame)>;

  struct Route {
    std::uint32_t id = 0;
    bool extended = false;
    Handler handler;

    auto key() const { return std::pair(id, extended); }
  };

  /// Before the first frame. Where two routes have the same identifier, the first one receives its frames.
  void add_route(std::uint32_t id, bool extended, Handler handler);

  /// What the bus has to deliver: one filter for each route.
  std::vector<can::Filter> filters() const;
  /// A frame without a route is ignored. A frame of the other identifier type in the place of a message goes
  /// to that message, which rejects and counts it.
  void pass_on(const can::Frame& frame) const;

 private:
  std::vector<Route> routes_;  ///< sorted by key
};

}  // namespace hystcan::controller
