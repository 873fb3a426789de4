#include "controller/frame_router.h"

#include <algorithm>

namespace hystcan::controller {

void FrameRouter::add_route(std::uint32_t id, bool extended, Handler handler) {
  Route route{.id = id, .extended = extended, .handler = std::move(handler)};
  const auto place = std::ranges::upper_bound(routes_, route.key(), {}, &Route::key);
  routes_.insert(place, std::move(route));
}

std::vector<can::Filter> FrameRouter::filters() const {
  std::vector<can::Filter> filters;
  filters.reserve(routes_.size());
  for (const Route& route : routes_) filters.push_back({.id = route.id, .extended = route.extended});
  return filters;
}

void FrameRouter::pass_on(const can::Frame& frame) const {
  for (const bool extended : {frame.extended, !frame.extended}) {
    const auto key = std::pair(frame.id, extended);
    const auto found = std::ranges::lower_bound(routes_, key, {}, &Route::key);
    if (found != routes_.end() && found->key() == key) return found->handler(frame);
  }
}

}  // namespace hystcan::controller
