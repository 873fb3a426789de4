#include "app/page/page_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/live/answer_json.h"
#include "app/live/control_protocol.h"
#include "controller/control/fault.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

constexpr std::size_t most_events = 200;
constexpr std::size_t most_changes = 20;
constexpr std::size_t longest_words = 200;

/// Returns a histogram with the upper edges 1, 2, 5, 10, ... us.
metrics::Histogram cycle_time_histogram() {
  return metrics::Histogram(
      {1, 2, 5, 10, 20, 50, 100, 200, 500, 1'000, 2'000, 5'000, 10'000, 20'000, 50'000, 100'000});
}

/// Returns the word with this index in the list. If there is none, returns the number as text.
std::string word_of(const std::vector<std::string>& words, double number) {
  const auto index = static_cast<std::size_t>(number);
  return number >= 0.0 && index < words.size() ? words[index] : fmt::format("{:g}", number);
}

std::string dumped(const json& command, const char* key) {
  return command.value(key, json()).dump(-1, ' ', false, json::error_handler_t::replace);
}

/// Returns the command in words, for example "x: go to 12.5 um".
std::string words_of_command(const json& command) {
  const ControlCommand& row = take_command(command, Server::controller);
  const bool has_axis = command.contains("axis") && command.at("axis").is_string();
  std::string words = has_axis ? command.at("axis").get<std::string>() + ": " : std::string();
  if (row.verb == Verb::go_to)
    words += fmt::format("go to {} um", dumped(command, "position_um"));
  else if (row.verb == Verb::set)
    words += fmt::format("set {} = {}", dumped(command, "key"), dumped(command, "value"));
  else if (row.verb == Verb::record)
    words += command.value("on", json()) == true ? "record" : "end the recording";
  else
    words += row.word;
  return words.substr(0, longest_words);
}

/// Returns an event for an action of a user. Its member `axis` is null, because the text contains the name of
/// the axis.
json act_event(const std::string& by, const std::string& level, const std::string& text) {
  return {{"type", "event"}, {"axis", nullptr}, {"by", by}, {"level", level}, {"text", text}};
}

/// Returns one event for each changed setting. If there are more than `most_changes`, the last event gives
/// the number of the other changes.
std::vector<json> change_events(const std::string& by, const std::string& what,
                                const std::vector<config::Change>& changes) {
  std::vector<json> events;
  for (std::size_t i = 0; i < std::min(changes.size(), most_changes); ++i) {
    const config::Change& change = changes[i];
    events.push_back(act_event(by, "info", fmt::format("{} {}", what, describe(change))));
    events.back().update({{"key", change.path}, {"from", change.from}, {"to", change.to}});
  }
  if (changes.size() > most_changes)
    events.push_back(
        act_event(by, "info", fmt::format("{}: {} more keys", what, changes.size() - most_changes)));
  return events;
}

std::string name_of_page(std::uint64_t page) { return fmt::format("page {}", page); }

}  // namespace

std::vector<json> command_events(const std::string& by, const json& command, const json& answer) {
  std::string words = words_of_command(command);
  const ControlCommand& row = take_command(command, Server::controller);
  if (!is_done(answer))
    return {act_event(by, "warning",
                      fmt::format("{}: refused: {}", words, read_object<RefusedAnswer>(answer).error))};
  if (row.controller == Reply::changes)
    if (const auto changed = read_answer<ChangesAnswer>(answer).changed; !changed.empty())
      return change_events(by, std::string(row.word), changed);
  if (row.controller == Reply::run) words += ": " + read_answer<RunAnswer>(answer).run;
  return {act_event(by, row.verb == Verb::stop ? "warning" : "info", words)};
}

PageEvents::PageEvents(PageClients& clients)
    : clients_(clients), turnaround_us_(cycle_time_histogram()), lateness_us_(cycle_time_histogram()) {}

void PageEvents::begin(const StreamGreeting& greeting) {
  at_ = CycleColumns::of(greeting);
  greeting_ = greeting;
  last_.assign(greeting.axes.size(), {-1.0, 0.0});
}

void PageEvents::put(std::span<const double> row) {
  turnaround_us_.add(row[at_.turnaround]);
  lateness_us_.add(row[at_.lateness]);
  newest_s_ = row[at_.time];
  const std::pair now{row[at_.state], row[at_.fault]};
  if (std::exchange(last_[static_cast<std::size_t>(row[at_.axis])], now) != now) add(event_of(row));
}

void PageEvents::add_act(std::uint64_t page, const std::string& level, const std::string& text) {
  add(act_event(name_of_page(page), level, text));
}

void PageEvents::add_command(std::uint64_t page, const json& command, const json& answer) {
  for (json& event : command_events(name_of_page(page), command, answer)) add(std::move(event));
}

void PageEvents::add_foreign_changes(const std::vector<config::Change>& changes) {
  for (json& event : change_events("file or control socket", "set", changes)) add(std::move(event));
}

/// Sends the event to all clients and stores it. Its time is the time of the newest row, or null before the
/// first row.
void PageEvents::add(json event) {
  event["time_s"] = newest_s_;
  events_.push_back(std::move(event));
  if (events_.size() > most_events) events_.pop_front();
  clients_.send_all(events_.back());
}

json PageEvents::event_of(std::span<const double> row) const {
  const auto axis = static_cast<std::size_t>(row[at_.axis]);
  const std::string& name = greeting_.axes[axis].name;
  json event{{"type", "event"}, {"axis", axis}, {"level", "info"}};
  const double fault = row[at_.fault];
  if (fault == 0.0) {
    event["text"] = fmt::format("{}: {}", name, word_of(greeting_.states, row[at_.state]));
    return event;
  }
  event["level"] = "error";
  event["text"] = fmt::format("{}: {}: {}", name, word_of(greeting_.states, row[at_.state]),
                              word_of(greeting_.faults, fault));
  if (fault > 0.0 && fault < static_cast<double>(controller::cause_count))
    event["remedy"] = controller::remedy(static_cast<controller::Cause>(fault));
  return event;
}

}  // namespace hystcan::app
