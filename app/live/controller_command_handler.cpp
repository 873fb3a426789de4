#include "app/live/controller_command_handler.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "app/live/answer_json.h"
#include "base/error.h"

namespace hystcan::app {
namespace {

using controller::Arrival;
using controller::AxisState;
using controller::Request;
using nlohmann::json;

constexpr auto poll_period = std::chrono::milliseconds(5);

// Longest timeout of the command `wait` in s: about twelve days. `wait` without timeout_s waits this long.
constexpr double longest_wait_s = 1e6;

/// Formats a JSON value as TOML. Text, numbers and booleans are the same in both formats. An object becomes
/// an inline table, {KEY = VALUE}. The elements of a list are converted one by one, because a list can
/// contain objects.
std::string toml_of(const json& value) {
  if (!value.is_structured()) return value.dump();
  std::vector<std::string> members;
  members.reserve(value.size());
  for (const auto& [key, member] : value.items())
    members.push_back(value.is_array() ? toml_of(member)
                                       : fmt::format("{} = {}", json(key).dump(), toml_of(member)));
  const std::string joined_members = fmt::format("{}", fmt::join(members, ", "));
  return value.is_array() ? "[" + joined_members + "]" : "{" + joined_members + "}";
}

AxisAnswer answer_of(const std::string& name, const controller::CycleRecord& record) {
  const controller::AxisReport& report = record.report;
  AxisAnswer axis{.name = name,
                  .state = report.state,
                  .fault = std::string(to_string(report.cause)),
                  .position_um = report.position_um,
                  .drive = report.drive,
                  .amplifier_output = record.amplifier_output,
                  .amplifier_output_age_s = record.amplifier_output_age_s,
                  .limits = controller::limits_to_string(report.limits),
                  .sample_missing = report.sample_missing};
  if (!report.arming_blocks.empty()) {
    axis.waits_for = to_string(report.arming_blocks.first());
    for (const controller::ArmingBlock block : report.arming_blocks.members())
      axis.waits_for_all.emplace_back(to_string(block));
  }
  if (report.cause != controller::Cause::none) {
    axis.fault_time_s = report.fault_time_s;
    axis.remedy = remedy(report.cause);
  }
  if (!axis.tracks()) return axis;
  axis.reference_um = report.reference_um;
  axis.error_um = report.reference_um - report.position_um;
  axis.finished = report.point.finished;
  axis.live_goal = report.point.live;
  axis.arrival = report.arrival;
  axis.learning = report.learning;
  return axis;
}

TimingAnswer timing_of(const controller::CycleRecord& record) {
  const auto us = [](can::Duration duration) { return 1e6 * can::seconds(duration); };
  return {.period_us = us(record.phases.period),
          .lateness_us = us(record.phases.lateness),
          .turnaround_us = us(record.phases.turnaround()),
          .execution_us = us(record.phases.execution)};
}

std::string joined(const std::vector<config::Change>& changes) {
  std::vector<std::string> texts;
  texts.reserve(changes.size());
  for (const config::Change& change : changes) texts.push_back(describe(change));
  return fmt::format("{}", fmt::join(texts, "; "));
}

/// Returns the answer to the command `wait`, which waits until an axis is in position; null if the client
/// must wait longer. Only a record after `since_cycle` counts: an older record may describe the axis before
/// its last command, because the telemetry thread delivers the records later.
json outcome_of(const controller::CycleRecord& record, std::uint64_t since_cycle) {
  if (record.cycle <= since_cycle) return {};
  const controller::AxisReport& report = record.report;
  if (report.state == AxisState::faulted) return refusal(fmt::format("faulted: {}", to_string(report.cause)));
  if (report.state == AxisState::offline) return refusal("the axis was stopped");
  if (report.state != AxisState::tracking) return {};
  if (report.arrival == Arrival::in_position)
    return answer_json(PositionAnswer{.position_um = report.position_um});
  if (report.arrival == Arrival::failed) return refusal("not in position within timeout_ms");
  if (report.arrival == Arrival::not_judged)
    return refusal("the axis has no [axis.control.in_position], which `wait` needs");
  return {};
}

}  // namespace

ControllerCommandHandler::ControllerCommandHandler(boost::asio::io_context& context,
                                                   controller::RequestLink& requests, CycleOutlets& outlets,
                                                   LiveConfig& live)
    : CommandHandler(Server::controller),
      timer_(context),
      requests_(requests),
      outlets_(outlets),
      live_(live),
      last_before_act_(live.axis_names().size()) {}

void ControllerCommandHandler::carry_out(Verb verb, const json& command, const Answer& answer) {
  if (closed_) return answer(refusal("the controller is ending"));
  if (const auto kind = row_of(verb).act) return act(*kind, command, answer);
  if (verb == Verb::status) return answer(status());
  if (verb == Verb::settings) return answer(settings());
  if (verb == Verb::record) return answer(record(command));
  if (verb == Verb::wait) return wait(command, answer);
  if (verb == Verb::set) return set(command, answer);
  if (verb == Verb::undo) return apply(live_.without_the_last(), answer);
  reload(answer);
}

json ControllerCommandHandler::status() const {
  const auto newest = outlets_.board.newest();
  StatusAnswer status{.time_s = newest.front().time_s,
                      .age_s = outlets_.board.age_s(),
                      .counters = newest.front().counters,
                      .timing = timing_of(newest.front()),
                      .recording = outlets_.recorder.status()};
  for (std::size_t i = 0; i < newest.size(); ++i)
    status.axes.push_back(answer_of(live_.axis_names()[i], newest[i]));
  if (const auto event = outlets_.board.last_event())
    status.last_event = {.text = describe(*event->event), .time_s = event->time_s};
  return answer_json(std::move(status));
}

json ControllerCommandHandler::record(const json& command) {
  const auto on = command.find("on");
  if (on == command.end() || !on->is_boolean()) throw Error("\"on\" is missing", expect("true or false"));
  if (*on == true) {
    const std::filesystem::path run = outlets_.recorder.start();
    spdlog::info("recording to {}", run.string());
    return answer_json(RunAnswer{.run = run.string()});
  }
  const std::filesystem::path run = outlets_.recorder.stop();
  if (run.empty()) return refusal("there is no recording to end");
  spdlog::info("ended the recording to {}", run.string());
  return answer_json(RunAnswer{.run = run.string()});
}

/// Returns the index of the axis that the command names. If it names none, returns the indices of all axes.
std::vector<std::size_t> ControllerCommandHandler::axes_of(const json& command) const {
  if (command.contains("axis")) return {live_.axis_index(text_of(command, "axis"))};
  std::vector<std::size_t> all(live_.axis_names().size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  return all;
}

std::vector<std::string> ControllerCommandHandler::texts_of(const Outcome& outcome) {
  std::vector<std::string> texts;
  for (const auto& [axis, why] : outcome) texts.push_back(fmt::format("{}: {}", axis, to_string(why)));
  return texts;
}

RefusedAnswer ControllerCommandHandler::refusal_of(const Outcome& outcome) {
  RefusedAnswer refused{.error = fmt::format("{}", fmt::join(texts_of(outcome), "; "))};
  for (const auto& [axis, why] : outcome) refused.refusals[axis] = controller::name_of(why);
  return refused;
}

void ControllerCommandHandler::act(Request::Kind kind, const json& command, const Answer& answer) {
  const double position_um = kind == Request::Kind::go_to ? number_of(command, "position_um") : 0.0;
  std::vector<std::unique_ptr<Request>> requests;
  for (const std::size_t axis : axes_of(command)) {
    auto request = std::make_unique<Request>();
    request->kind = kind;
    request->axis = axis;
    request->position_um = position_um;
    requests.push_back(std::move(request));
  }
  const std::size_t asked = requests.size();
  ask_all(std::move(requests), [asked, answer](const Outcome& outcome) {
    const auto needless =
        static_cast<std::size_t>(std::ranges::count_if(outcome, controller::is_needless, &Refused::why));
    if (needless == asked || needless < outcome.size()) return answer(answer_json(refusal_of(outcome)));
    answer(answer_json(DoneAnswer{.nothing_to_do = texts_of(outcome)}));
  });
}

void ControllerCommandHandler::set(const json& command, const Answer& answer) {
  const auto value = command.find("value");
  if (value == command.end())
    throw Error("\"value\" is missing", expect("the new value of the key, such as 0.08 or \"inverse\""));
  apply(live_.with(text_of(command, "axis"), text_of(command, "key"), toml_of(*value)), answer);
}

json ControllerCommandHandler::settings() const {
  const std::string file = std::filesystem::absolute(live_.file()).string();
  try {
    return answer_json(SettingsAnswer{.file = file,
                                      .settings = live_.settings(),
                                      .unsaved = config::changes(live_.settings_of_file(), live_.settings()),
                                      .undo = live_.single_settings()});
  } catch (const Error& error) {  // the file was changed since the last load and is invalid now
    return answer_json(RefusedAnswer{.error = error.what(), .file = file});
  }
}

void ControllerCommandHandler::reload(const Answer& answer) {
  try {
    apply(live_.reread(), answer);
  } catch (const std::exception& error) {
    spdlog::error("configuration not applied: {}", error_text(error));
    answer(refusal(error_text(error)));
  }
}

void ControllerCommandHandler::apply(LiveConfig::Prepared prepared, const Answer& answer) {
  if (!prepared.after_restart.empty()) {
    const std::string reason =
        fmt::format("nothing was changed; a restart is needed: {}", joined(prepared.after_restart));
    spdlog::warn("configuration not applied: {}", reason);
    return answer(refusal(reason));
  }
  auto requests = std::move(prepared.requests);
  const auto shared = std::make_shared<LiveConfig::Prepared>(std::move(prepared));
  ask_all(std::move(requests), [this, shared, answer](const Outcome& outcome) {
    if (!outcome.empty()) {
      const RefusedAnswer refused = refusal_of(outcome);
      spdlog::error("configuration not applied: {}", refused.error);
      live_.mark_uncertain(*shared);
      return answer(answer_json(refused));
    }
    live_.accept(*shared);
    outlets_.recorder.add(shared->at_once);
    for (const config::Change& change : shared->at_once) spdlog::info("configuration: {}", describe(change));
    answer(answer_json(ChangesAnswer{.changed = shared->at_once}));
  });
}

/// Sends all requests to the control thread. Calls `done` with the refusals after the last request was
/// answered.
void ControllerCommandHandler::ask_all(std::vector<std::unique_ptr<Request>> requests,
                                       std::function<void(const Outcome&)> done) {
  struct Round {
    std::size_t open;
    Outcome outcome;
    std::function<void(const Outcome&)> done;
  };
  if (requests.empty()) return done({});
  const auto round = std::make_shared<Round>(Round{requests.size(), {}, std::move(done)});
  const auto close_one = [this, round](Request& request) {
    std::uint64_t& last_before = last_before_act_.at(request.axis);
    last_before = std::max(last_before, request.cycle);
    if (request.refusal) round->outcome.push_back({live_.axis_names().at(request.axis), *request.refusal});
    if (--round->open == 0) round->done(round->outcome);
  };
  for (auto& request : requests) {
    Request* asked = request.get();
    if (requests_.ask(std::move(request))) {
      pending_.emplace(asked, close_one);
    } else {
      Request refused{.axis = asked->axis, .refusal = controller::Refusal::too_many_requests};
      close_one(refused);
    }
  }
  arm();
}

void ControllerCommandHandler::wait(const json& command, const Answer& answer) {
  const double timeout_s = command.contains("timeout_s") ? number_of(command, "timeout_s") : longest_wait_s;
  if (!(timeout_s > 0.0 && timeout_s <= longest_wait_s))
    return answer(refusal(fmt::format("timeout_s is {}, expected > 0 and <= {}", timeout_s, longest_wait_s)));
  const std::size_t axis = live_.axis_index(text_of(command, "axis"));
  const auto duration = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(timeout_s));
  waiters_.push_back({.axis = axis,
                      .since_cycle = std::max(outlets_.board.newest()[axis].cycle, last_before_act_[axis]),
                      .deadline = std::chrono::steady_clock::now() + duration,
                      .answer = answer});
  arm();
}

void ControllerCommandHandler::arm() {
  if (armed_ || (pending_.empty() && waiters_.empty())) return;
  armed_ = true;
  timer_.expires_after(poll_period);
  timer_.async_wait([this](const boost::system::error_code& error) {
    armed_ = false;
    if (error) return;
    collect_answers();
    answer_waiters();
    arm();
  });
}

void ControllerCommandHandler::collect_answers() {
  while (const auto request = requests_.take_answer()) {
    if (const auto pending = pending_.extract(request.get())) pending.mapped()(*request);
  }
}

void ControllerCommandHandler::answer_waiters() {
  const auto newest = outlets_.board.newest();
  const auto now = std::chrono::steady_clock::now();
  std::vector<Waiter> waiting = std::exchange(waiters_, {});
  for (Waiter& waiter : waiting) {
    json outcome = outcome_of(newest[waiter.axis], waiter.since_cycle);
    if (outcome.is_null() && now >= waiter.deadline)
      outcome = refusal("timed out: not in position within timeout_s");
    if (outcome.is_null())
      waiters_.push_back(std::move(waiter));
    else
      waiter.answer(std::move(outcome));
  }
}

void ControllerCommandHandler::forget(const void* client) {
  std::erase_if(waiters_, [&](const Waiter& waiter) { return waiter.answer.client == client; });
}

void ControllerCommandHandler::close() {
  closed_ = true;
  collect_answers();
  for (Waiter& waiter : std::exchange(waiters_, {})) waiter.answer(refusal("the controller is ending"));
}

}  // namespace hystcan::app
