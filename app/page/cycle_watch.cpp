#include "app/page/cycle_watch.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "controller/control/fault.h"

namespace hystcan::app {
namespace {

constexpr std::size_t most_events = 200;

/// The word with this number; the number itself if the list has no such word.
std::string word_of(const nlohmann::json& words, double number) {
  const auto index = static_cast<std::size_t>(number);
  return number >= 0.0 && index < words.size() ? words[index].get<std::string>()
                                               : fmt::format("{:g}", number);
}

}  // namespace

void CycleWatch::begin(const nlohmann::json& greeting) {
  at_ = CycleColumns::of(greeting);
  greeting_ = greeting;
  last_.assign(greeting.at("axes").size(), {});
}

std::optional<nlohmann::json> CycleWatch::put(std::span<const double> row) {
  turnaround_.put(row[at_.turnaround]);
  lateness_.put(row[at_.lateness]);
  newest_s_ = row[at_.time];
  Last& last = last_[static_cast<std::size_t>(row[at_.axis])];
  if (row[at_.state] == last.state && row[at_.fault] == last.fault) return std::nullopt;
  last = {row[at_.state], row[at_.fault]};
  return keep(event_of(row));
}

const nlohmann::json& CycleWatch::keep(nlohmann::json event) {
  event["time_s"] = newest_s_;
  events_.push_back(std::move(event));
  if (events_.size() > most_events) events_.pop_front();
  return events_.back();
}

nlohmann::json CycleWatch::event_of(std::span<const double> row) const {
  const auto axis = static_cast<std::size_t>(row[at_.axis]);
  const std::string name = greeting_.at("axes")[axis].at("name");
  nlohmann::json event{{"type", "event"}, {"axis", axis}, {"level", "info"}};
  const double fault = row[at_.fault];
  if (fault == 0.0) {
    event["text"] = fmt::format("{}: {}", name, word_of(greeting_.at("states"), row[at_.state]));
    return event;
  }
  event["level"] = "error";
  event["text"] = fmt::format("{}: {}: {}", name, word_of(greeting_.at("states"), row[at_.state]),
                              word_of(greeting_.at("faults"), fault));
  if (fault > 0.0 && fault < static_cast<double>(controller::cause_count))
    event["remedy"] = controller::remedy(static_cast<controller::Cause>(fault));
  return event;
}

}  // namespace hystcan::app
