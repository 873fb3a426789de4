#include "node/station.h"

#include <algorithm>
#include <utility>

namespace hystcan::node {

Station::Station(can::Scheduler& scheduler, can::Duration heartbeat_period)
    : scheduler_(scheduler), heartbeat_period_(heartbeat_period), listened_(scheduler.make_timer([this] {
        if (taken_node()) return;
        for (const auto& node : nodes_) node->start();
        on_started_();
      })) {}

void Station::start(std::function<void()> on_started) {
  on_started_ = std::move(on_started);
  listened_->expire_at(scheduler_.now() + heartbeat_period_);
}

std::optional<std::uint8_t> Station::taken_node() const {
  const auto taken = std::ranges::find_if(nodes_, [](const auto& node) { return node->is_taken(); });
  if (taken == nodes_.end()) return std::nullopt;
  return (*taken)->number();
}

void Station::shut_down() {
  for (const auto& node : nodes_) node->shut_down();
}

std::vector<const can::Bus*> Station::connections() const {
  std::vector<const can::Bus*> all;
  all.reserve(nodes_.size());
  for (const auto& node : nodes_) all.push_back(&std::as_const(*node).bus());
  return all;
}

}  // namespace hystcan::node
