#include "app/live/node_watch.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "app/live/report.h"
#include "app/live/state_log.h"
#include "app/live/twin_command_handler.h"
#include "base/error.h"

namespace hystcan::app {

NodeWatch::NodeWatch(const node::Station& station, std::vector<WatchedAmplifier> amplifiers,
                     can::Scheduler& scheduler, const std::string& interface, std::function<void()> on_taken)
    : station_(station),
      amplifiers_(std::move(amplifiers)),
      scheduler_(scheduler),
      started_(scheduler.now()),
      seen_(amplifiers_.size()),
      bus_log_(interface, bus_log_sink()),
      on_taken_(std::move(on_taken)),
      timer_(scheduler.make_timer([this] { look(); })) {
  look();
}

void NodeWatch::log_bus() {
  const auto connections = station_.connections();
  bus_log_.sample(can::report_of(connections, can::seconds(scheduler_.now() - started_)));
  bus_log_.write();
}

void NodeWatch::look() {
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const node::AmplifierChannel& amplifier = *amplifiers_[i].amplifier;
    if (std::exchange(seen_[i], amplifier.state()) == amplifier.state()) continue;
    const bool silence = (amplifier.fault() & can::amp_fault::command_timeout) != 0;
    spdlog::info("{}: amplifier {}{}", amplifiers_[i].wire.name, to_string(amplifier.state()),
                 silence ? ": no commands, output at its safe value" : "");
  }
  log_bus();
  if (station_.taken_node()) return on_taken_();
  timer_->expire_at(scheduler_.now() + std::chrono::milliseconds(50));
}

std::string closing_text(const node::Station& station, const std::vector<WatchedAmplifier>& amplifiers) {
  const auto connections = station.connections();
  BusClosing closing{.bus = can::report_of(connections, 0.0)};
  closing.rejected.reserve(amplifiers.size());
  for (const auto& [wire, amplifier] : amplifiers)
    if (amplifier->index() == 0)  // all axes of a node use the same command: count it once
      closing.rejected.push_back(can::rejected_frames(can::message_map<can::AmpCommand>(wire)->message,
                                                      amplifier->node().checker()));
  std::string text;
  for (const std::string& line : describe(closing)) text += line + "\n";
  return text;
}

void refuse_if_taken(const node::Station& station, const std::string& interface) {
  const auto taken = station.taken_node();
  if (!taken) return;
  throw RunError(interface,
                 fmt::format("node {} is already on this bus, as another twin or as the real node", *taken),
                 {.remedy = "stop one of the two nodes"});
}

}  // namespace hystcan::app
