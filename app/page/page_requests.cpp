// What the clients of the page ask for.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "app/live/command_handler.h"
#include "app/page/bode.h"
#include "app/page/command_event.h"
#include "app/page/config_save.h"
#include "app/page/page_service.h"
#include "app/stage/config_edit.h"
#include "base/error.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

constexpr int most_messages_per_s = 50;
constexpr auto answer_to_a_wrong_token = std::chrono::seconds(1);
constexpr double slowest_view_Hz = 10.0;
constexpr double fastest_view_Hz = 1000.0;
constexpr const char* no_token = "this needs the token: hystcan page CONFIG --token shows it";
constexpr const char* no_role = "another page, or none, has the writer's role: take it first";

/// What the control socket may be asked for through the page; `stop` has its own request.
constexpr auto page_commands = std::to_array<std::string_view>(
    {"go_to", "resume", "set", "undo", "reload", "revert", "enable", "disable", "clear", "record"});

/// The overrides that give the loop and the model in force, which do not depend on the setpoint.
std::vector<config::Setting> overrides_of(const json& unsaved) {
  std::vector<config::Setting> overrides;
  for (const json& change : unsaved) {
    const std::string key = change.at("key"), value = change.at("to");
    if (!value.empty() && key.find(".setpoint[") == std::string::npos) overrides.push_back({key, value});
  }
  return overrides;
}

std::string name_of_page(std::uint64_t client) { return fmt::format("page {}", client); }

}  // namespace

void PageService::received(WebClient& web, std::string_view text) {
  const auto found = clients_.find(&web);
  if (found == clients_.end()) return;
  Client& client = found->second;
  const json request = parse_command(std::string(text));
  if (is_too_much(client) &&
      !(client.is_authorised && request.is_object() && request.value("do", json()) == "stop"))
    return web.cut_off();
  Asked asked{client.number, nullptr};
  if (!request.is_object()) return refuse(asked, "expected a JSON object");
  if (const auto id = request.find("id"); id != request.end() && id->is_number()) asked.id = *id;
  if (asked.id.is_null()) return refuse(asked, "\"id\" is missing, expected a number");
  try {
    obey(client, asked, request);
  } catch (const std::exception& error) {  // the request is invalid; nothing has changed
    refuse(asked, error_text(error));
  }
}

bool PageService::is_too_much(Client& client) const {
  const Clock::time_point now = Clock::now();
  if (now - client.second >= std::chrono::seconds(1)) {
    client.second = now;
    client.messages = 0;
  }
  return ++client.messages > most_messages_per_s;
}

void PageService::obey(Client& client, const Asked& asked, const json& request) {
  enum class Needs : std::uint8_t { nothing, token, role };
  struct Entry {
    Request request;
    Needs needs;
  };
  static const std::map<std::string, Entry> requests{
      {"token", {&PageService::token, Needs::nothing}},
      {"view", {&PageService::view, Needs::nothing}},
      {"settings", {&PageService::settings, Needs::nothing}},
      {"bode", {&PageService::bode, Needs::nothing}},
      {"curves", {&PageService::curves, Needs::nothing}},
      {"trigger", {&PageService::trigger, Needs::nothing}},
      {"untrigger", {&PageService::untrigger, Needs::nothing}},
      {"stop", {&PageService::stop, Needs::token}},
      {"take_writer", {&PageService::take_writer, Needs::token}},
      {"release_writer", {&PageService::release_writer, Needs::nothing}},
      {"command", {&PageService::command, Needs::token}},
      {"start", {&PageService::start, Needs::token}},
      {"save", {&PageService::save, Needs::role}},
      {"undo_save", {&PageService::undo_save, Needs::role}}};
  const std::string what = text_of(request, "do");
  const auto found = requests.find(what);
  if (found == requests.end()) return refuse(asked, fmt::format("\"{}\" is not a request", what));
  if (found->second.needs != Needs::nothing && !client.is_authorised) {
    ++counters_.refused;
    return refuse(asked, no_token);
  }
  if (found->second.needs == Needs::role && writer_ != client.number) return refuse(asked, no_role);
  (this->*found->second.request)(client, asked, request);
}

void PageService::reply(const Asked& asked, json answer) {
  answer["type"] = "answer";
  answer["id"] = asked.id;
  if (Client* client = client_with(asked.client))
    client->web.send_text(answer.dump(-1, ' ', false, json::error_handler_t::replace));
}

PageService::Client* PageService::client_with(std::uint64_t number) {
  const auto found =
      std::ranges::find(clients_, number, [](const auto& client) { return client.second.number; });
  return found == clients_.end() ? nullptr : &found->second;
}

void PageService::refuse(const Asked& asked, const std::string& reason) { reply(asked, refusal(reason)); }

void PageService::token(Client& client, const Asked& asked, const json& request) {
  if (client.waits_for_token) return refuse(asked, "the answer to the last token is under way");
  if (access_.is_token(text_of(request, "token"))) {
    client.is_authorised = true;
    reply(asked, {{"ok", true}});
    return send_writer(client);
  }
  ++counters_.refused;
  client.waits_for_token = true;
  const auto later = std::make_shared<boost::asio::steady_timer>(context_, answer_to_a_wrong_token);
  later->async_wait([this, later, asked](const boost::system::error_code&) {
    if (Client* waiting = client_with(asked.client)) waiting->waits_for_token = false;
    refuse(asked, "this is not the token: hystcan page CONFIG --token shows it");
  });
}

void PageService::view(Client& client, const Asked& asked, const json& request) {
  const double rate = number_of(request, "rate_Hz");
  if (!(rate >= slowest_view_Hz && rate <= fastest_view_Hz))
    return refuse(asked,
                  fmt::format("rate_Hz is {}, expected {} to {}", rate, slowest_view_Hz, fastest_view_Hz));
  client.rate = std::round(rate);
  set_rates();
  reply(asked, {{"ok", true}});
}

/// Throws Error if the controller runs with another file than the page's.
void PageService::require_the_same_file(const json& settings) const {
  const std::filesystem::path of_controller = settings.at("file").get<std::string>();
  std::error_code error;
  if (!std::filesystem::equivalent(of_controller, options_.config, error))
    throw Error(fmt::format("the controller runs with {}, this page with {}: start it with the same file",
                            of_controller.string(), options_.config.string()));
}

void PageService::with_settings(const Asked& asked, std::function<void(const json& settings)> work) {
  const bool waits =
      slow_requests_.add(asked.client, [this, asked, work = std::move(work)](const RequestQueue::Done& done) {
        reading_.ask({{"do", "settings"}}, [this, asked, work, done, changes = changes_](const json& answer) {
          try {
            if (!answer.value("ok", false)) {
              reply(asked, answer);
              return done();
            }
            if (changes == changes_ && !writing_.is_busy()) compare_settings(answer.at("settings"));
            work(answer);
          } catch (const std::exception& error) {
            refuse(asked, error_text(error));
          }
          done();
        });
      });
  if (!waits)
    refuse(asked, fmt::format("{} requests of this page wait already", RequestQueue::most_of_a_client));
}

void PageService::settings(Client&, const Asked& asked, const json&) {
  with_settings(asked, [this, asked](json answer) {
    answer.erase("file");
    answer["undo_save"] = std::filesystem::exists(kept_beside(options_.config));
    reply(asked, std::move(answer));
  });
}

/// Replies with what `make` makes of the axis with the settings in force.
void PageService::reply_of_axis(const Asked& asked, const json& request, const MakeOfAxis& make) {
  const std::string axis = text_of(request, "axis");
  with_settings(asked, [this, asked, axis, make](const json& answer) {
    require_the_same_file(answer);
    const config::Config config = config::load(options_.config, overrides_of(answer.at("unsaved")));
    json made = make(config, config.axes[index_of_axis(config, axis)]);
    made["ok"] = true;
    reply(asked, std::move(made));
  });
}

void PageService::bode(Client&, const Asked& asked, const json& request) {
  reply_of_axis(asked, request, [](const config::Config& config, const config::AxisConfig& axis) {
    return bode_of(axis, 1.0 / config.controller.rate_Hz);
  });
}

void PageService::curves(Client&, const Asked& asked, const json& request) {
  reply_of_axis(asked, request, [](const config::Config& config, const config::AxisConfig& axis) {
    return reference_curves_of(axis, 1.0 / config.controller.rate_Hz);
  });
}

void PageService::trigger(Client& client, const Asked& asked, const json& request) {
  if (!controller_.is_there()) return refuse(asked, "no cycles come: there is nothing to capture");
  client.trigger.emplace(Trigger::of(request, controller_.greeting()), watch_.columns());
  reply(asked, {{"ok", true}});
}

void PageService::untrigger(Client& client, const Asked& asked, const json&) {
  client.trigger.reset();
  reply(asked, {{"ok", true}});
}

void PageService::give_role_to(std::uint64_t client) {
  if (writer_ == client) return;
  writing_.close();  // the controller's right to write goes with the role
  if (client != 0)
    tell_all({act_event(name_of_page(client), "info", "takes control")});
  else
    tell_all({act_event(name_of_page(writer_), "info", "gives control back")});
  writer_ = client;
  for (auto& [web, other] : clients_) send_writer(other);
}

void PageService::take_writer(Client& client, const Asked& asked, const json& request) {
  const bool is_forced = request.contains("force") && request.at("force") == true;
  if (writer_ != 0 && writer_ != client.number && !is_forced)
    return refuse(asked, "another page has the writer's role");
  give_role_to(client.number);
  reply(asked, {{"ok", true}});
}

void PageService::release_writer(Client& client, const Asked& asked, const json&) {
  if (writer_ == client.number) give_role_to(0);
  reply(asked, {{"ok", true}});
}

/// `disable` ends something: like `stop`, it needs no role.
void PageService::command(Client& client, const Asked& asked, const json& request) {
  const auto command = request.find("command");
  if (command == request.end() || !command->is_object())
    return refuse(asked, "\"command\" is missing, expected a command of the control socket");
  const std::string what = text_of(*command, "do");
  if (std::ranges::find(page_commands, what) == page_commands.end())
    return refuse(asked, fmt::format("\"{}\" is no command of the page, expected {}", what,
                                     fmt::join(page_commands, ", ")));
  const bool is_open_to_all = what == "disable";
  if (!is_open_to_all && writer_ != client.number) return refuse(asked, no_role);
  spdlog::info("page {}: {}", asked.client, command->dump(-1, ' ', true, json::error_handler_t::replace));
  ++changes_;
  ControlLink& link = is_open_to_all ? stopping_ : writing_;
  link.ask(*command, [this, asked, given = *command](const json& answer) {
    command_answered(name_of_page(asked.client), given, answer);
    const bool is_done = answer.value("ok", false);
    json told{{"ok", is_done}, {"answer", answer}};
    if (!is_done) told["error"] = answer.value("error", "refused");
    reply(asked, std::move(told));
  });
}

void PageService::stop(Client&, const Asked& asked, const json&) {
  spdlog::warn("page {}: stop", asked.client);
  const json command{{"do", "stop"}};
  stopping_.ask(command, [this, asked, command](const json& answer) {
    command_answered(name_of_page(asked.client), command, answer);
    reply(asked, answer);
    stopping_.close();
  });
}

void PageService::start(Client&, const Asked& asked, const json&) {
  if (!options_.start_again)
    return refuse(asked,
                  fmt::format("only a demo starts from its page, expected: {}", options_.start_command));
  options_.start_again();
  spdlog::info("page {}: start again", asked.client);
  tell_all({act_event(name_of_page(asked.client), "info", "start again")});
  reply(asked, {{"ok", true}});
}

void PageService::save(Client&, const Asked& asked, const json& request) {
  reply_or_write(asked, request,
                 [this](const json& answer) { return save_of(options_.config, answer.at("unsaved")); });
}

void PageService::undo_save(Client&, const Asked& asked, const json& request) {
  reply_or_write(asked, request, [this](const json&) { return undo_of(options_.config); });
}

/// Replies with the difference; if the request has its digest, writes the file.
void PageService::reply_or_write(const Asked& asked, const json& request, const MakeSave& make) {
  const std::string digest = request.contains("digest") ? text_of(request, "digest") : "";
  with_settings(asked, [this, asked, digest, make](const json& answer) {
    require_the_same_file(answer);
    const ConfigSave save = make(answer);
    json told{{"ok", true}, {"kept", kept_beside(options_.config).filename().string()}};
    if (digest.empty()) {
      told.update({{"diff", save.diff}, {"digest", save.digest}});
      return reply(asked, std::move(told));
    }
    if (digest != save.digest)
      return refuse(asked,
                    "the file or the settings have changed since the difference was shown: look again");
    write_save(options_.config, save);
    const std::string done =
        fmt::format("{} {}", save.undoes ? "undo save of" : "save", options_.config.filename().string());
    spdlog::info("page {}: {}", asked.client, done);
    tell_all({act_event(name_of_page(asked.client), "info", done)});
    save.undoes ? reload_restored(asked, std::move(told)) : reply(asked, std::move(told));
  });
}

/// The controller takes the restored file over; if it does not, `not_applied` says why.
void PageService::reload_restored(const Asked& asked, json told) {
  const json command{{"do", "reload"}};
  ++changes_;
  writing_.ask(command, [this, asked, command, told = std::move(told)](const json& answer) mutable {
    command_answered(name_of_page(asked.client), command, answer);
    if (!answer.value("ok", false)) told["not_applied"] = answer.value("error", "");
    reply(asked, std::move(told));
  });
}

}  // namespace hystcan::app
