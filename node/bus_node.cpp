#include "node/bus_node.h"

#include <vector>

namespace hystcan::node {
namespace {

std::vector<can::Filter> filters_of(std::uint8_t node, const std::optional<can::Filter>& obeys) {
  std::vector filters{can::Filter{can::nmt_id}, can::Filter{can::sync_id},
                      can::Filter{can::heartbeat_base + node}, can::Filter{can::sdo_request_base + node}};
  if (obeys) filters.push_back(*obeys);
  return filters;
}

}  // namespace

BusNode::BusNode(std::uint8_t number, const CommonConfig& common, can::Scheduler& scheduler,
                 const can::Attach& attach, const std::optional<can::Filter>& obeys)
    : number_(number),
      slots_(common.background_slots),
      bus_(attach(filters_of(number, obeys))),
      nmt_(*bus_, scheduler, number, common.heartbeat_period,
           [this](can::NmtState state) {
             if (state == can::NmtState::boot_up && nmt_.last_reset() == can::NmtCommand::reset_node)
               sdo_.reset();
             on_nmt(state);
           }),
      sdo_(number) {}

void BusNode::handle(const can::Frame& frame) {
  nmt_.handle(frame);
  if (nmt_.is_silent() || nmt_.state() == can::NmtState::stopped) return;
  if (const auto response = sdo_.answer(frame)) bus_->send(*response);
}

bool BusNode::take_slot(std::uint8_t sync_counter) {
  return can::is_in_slot(number_, sync_counter, slots_) && !(has_slot() && nmt_.on_slot());
}

void BusNode::restart() {
  if (is_on_the_bus()) nmt_.start();
}

}  // namespace hystcan::node
