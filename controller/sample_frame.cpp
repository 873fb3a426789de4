#include "controller/sample_frame.h"

#include <algorithm>
#include <utility>

namespace hystcan::controller {

std::size_t SampleFrame::add_sync_counter(const std::string& signal) {
  const auto same = std::ranges::find(counters_, signal, &SyncCounter::signal);
  const auto place = static_cast<std::size_t>(same - counters_.begin());
  if (same == counters_.end()) counters_.push_back({.signal = signal});
  return place;
}

bool SampleFrame::is_doubled(std::size_t place, std::uint8_t sync_counter, const can::Frame& frame,
                             std::uint64_t cycle) {
  constexpr std::uint64_t forgotten_after = can::sync_counter_max / 2;
  SyncCounter& counter = counters_[place];
  if (std::exchange(counter.decided_for, checker().accepted()) == checker().accepted())
    return counter.is_doubled;
  const NamedSync last = std::exchange(counter.named[sync_counter], {cycle, frame});
  return counter.is_doubled =
             last.cycle != 0 && cycle - last.cycle < forgotten_after && !(last.frame == frame);
}

}  // namespace hystcan::controller
