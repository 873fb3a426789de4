#include "app/page/page_requests.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "app/live/answer_json.h"
#include "app/live/control_protocol.h"
#include "app/page/axis_curves.h"
#include "app/stage/config_edit.h"
#include "base/error.h"
#include "config/schema/settings.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

constexpr auto answer_to_a_wrong_token = std::chrono::seconds(1);
constexpr double slowest_view_Hz = 10.0;
constexpr double fastest_view_Hz = 1000.0;
constexpr const char* no_token = "this request needs the token; show it with hystcan page CONFIG --token";
constexpr const char* no_role = "this page does not have the writer's role; take the role first";

/// Returns the list of commands that a page may send with the request `command`, for an error message. The
/// command `stop` is not in the list, because it has its own request.
std::string page_commands() {
  std::map<int, std::string_view> words;
  for (const ControlCommand& row : protocol::commands)
    if (row.page_place > 0) words[row.page_place] = row.word;
  std::string text;
  for (const auto& placed : words) text.append(text.empty() ? "" : ", ").append(placed.second);
  return text;
}

/// Returns the settings of the running controller that differ from the file. With these settings, the
/// configuration of the file has the present control loop and model. Settings of the reference segments are
/// left out, because loop and model do not depend on them.
std::vector<config::Setting> overrides_of(const std::vector<config::Change>& unsaved) {
  const std::string of_segments = fmt::format(".{}[", config::setpoint_key);
  std::vector<config::Setting> overrides;
  for (const config::Change& change : unsaved)
    if (!change.to.empty() && change.path.find(of_segments) == std::string::npos)
      overrides.push_back({change.path, change.to});
  return overrides;
}

/// Returns the settings that can be changed while the controller runs, as JSON (docs/page_protocol.md).
json keys_json(const config::Config& config) {
  json list = json::array();
  for (const config::Key& key : config::running_keys(config)) {
    json& about = list.emplace_back(json{{"key", key.path}, {"meaning", key.meaning}});
    if (std::isfinite(key.range.lo) || std::isfinite(key.range.hi)) about["range"] = key.range.describe();
    if (!key.choices.empty()) about["choices"] = key.choices;
    about["unit"] = key.unit();
  }
  return list;
}

}  // namespace

PageRequests::PageRequests(boost::asio::io_context& context, const PageOptions& options,
                           const PageAccess& access, PageClients& clients, PageEvents& events,
                           const PageStream& controller, WriterRole& role)
    : context_(context),
      options_(options),
      access_(access),
      clients_(clients),
      events_(events),
      controller_(controller),
      role_(role),
      queue_(context) {}

void PageRequests::receive(PageClient& client, std::string_view text) {
  const json request = parse_command(std::string(text));
  if (client.sends_too_much() &&
      !(client.is_authorised && request.is_object() && request.value("do", json()) == "stop"))
    return client.web.cut_off();
  RequestId request_id{client.number, nullptr};
  if (!request.is_object()) return refuse(request_id, "expected a JSON object");
  if (const auto id = request.find("id"); id != request.end() && id->is_number()) request_id.id = *id;
  if (request_id.id.is_null()) return refuse(request_id, "\"id\" is missing, expected a number");
  try {
    dispatch(client, request_id, request);
  } catch (const std::exception& error) {  // an invalid request changes nothing
    refuse(request_id, error_text(error));
  }
}

void PageRequests::dispatch(PageClient& client, const RequestId& request_id, const json& request) {
  enum class Needs : std::uint8_t { nothing, token, role };
  static const std::map<std::string, std::pair<Request, Needs>> requests{
      {"token", {&PageRequests::token, Needs::nothing}},
      {"view", {&PageRequests::view, Needs::nothing}},
      {"settings", {&PageRequests::settings, Needs::nothing}},
      {"bode", {&PageRequests::bode, Needs::nothing}},
      {"curves", {&PageRequests::curves, Needs::nothing}},
      {"trigger", {&PageRequests::trigger, Needs::nothing}},
      {"untrigger", {&PageRequests::untrigger, Needs::nothing}},
      {"stop", {&PageRequests::stop, Needs::token}},
      {"take_writer", {&PageRequests::take_writer, Needs::token}},
      {"release_writer", {&PageRequests::release_writer, Needs::nothing}},
      {"command", {&PageRequests::command, Needs::token}},
      {"start", {&PageRequests::start, Needs::token}},
      {"save", {&PageRequests::save, Needs::role}},
      {"undo_save", {&PageRequests::undo_save, Needs::role}}};
  const std::string what = text_of(request, "do");
  const auto found = requests.find(what);
  if (found == requests.end()) return refuse(request_id, fmt::format("\"{}\" is not a request", what));
  const auto& [carry_out, needs] = found->second;
  if (needs != Needs::nothing && !client.is_authorised) {
    ++clients_.counters.refused;
    return refuse(request_id, no_token);
  }
  if (needs == Needs::role && !role_.is_of(client)) return refuse(request_id, no_role);
  (this->*carry_out)(client, request_id, request);
}

void PageRequests::reply(const RequestId& request_id, json answer) {
  answer["type"] = "answer";
  answer["id"] = request_id.id;
  if (PageClient* client = clients_.with(request_id.client)) client->send(answer);
}

void PageRequests::refuse(const RequestId& request_id, const std::string& reason) {
  reply(request_id, refusal(reason));
}

void PageRequests::token(PageClient& client, const RequestId& request_id, const json& request) {
  if (client.waits_for_token) return refuse(request_id, "the previous token is still being checked");
  if (access_.is_token(text_of(request, "token"))) {
    client.is_authorised = true;
    reply(request_id, {{"ok", true}});
    return role_.show_to(client);
  }
  ++clients_.counters.refused;
  client.waits_for_token = true;
  const auto later = std::make_shared<boost::asio::steady_timer>(context_, answer_to_a_wrong_token);
  later->async_wait([this, later, request_id](const boost::system::error_code&) {
    if (PageClient* waiting = clients_.with(request_id.client)) waiting->waits_for_token = false;
    refuse(request_id, "the token is wrong; show it with hystcan page CONFIG --token");
  });
}

void PageRequests::view(PageClient& client, const RequestId& request_id, const json& request) {
  const double rate = number_of(request, "rate_Hz");
  if (!(rate >= slowest_view_Hz && rate <= fastest_view_Hz))
    return refuse(request_id,
                  fmt::format("rate_Hz is {}, expected {} to {}", rate, slowest_view_Hz, fastest_view_Hz));
  client.rate = std::round(rate);
  reply(request_id, {{"ok", true}});
}

/// Throws Error if the controller uses another configuration file than this page, because a save would then
/// change the wrong file.
void PageRequests::require_the_same_file(const SettingsAnswer& settings) const {
  std::error_code error;
  if (!std::filesystem::equivalent(settings.file, options_.config, error))
    throw Error(fmt::format("the controller uses {}, this page uses {}; start the page with the same file",
                            settings.file, options_.config.string()));
}

void PageRequests::with_settings(const RequestId& request_id, std::function<void(const SettingsAnswer&)> work,
                                 bool needs_valid_file) {
  const bool waits =
      queue_.add(request_id.client, [=, this, work = std::move(work)](const RequestQueue::Done& done) {
        role_.read_settings([=, this](const json& answer) {
          try {
            if (is_done(answer)) {
              work(read_answer<SettingsAnswer>(answer));
            } else if (const auto refused = read_object<RefusedAnswer>(answer);
                       !needs_valid_file && !refused.file.empty()) {
              work({.file = refused.file});
            } else {
              reply(request_id, answer);
            }
          } catch (const std::exception& error) {
            refuse(request_id, error_text(error));
          }
          done();
        });
      });
  if (!waits)
    refuse(request_id,
           fmt::format("{} requests of this page are already waiting", RequestQueue::most_of_a_client));
}

void PageRequests::settings(PageClient&, const RequestId& request_id, const json&) {
  with_settings(request_id, [this, request_id](const SettingsAnswer& settings) {
    json answer = answer_json(settings);
    answer.erase("file");
    for (std::size_t i = 0; i < settings.settings.size(); ++i)
      answer["settings"][i]["unit"] = config::unit_of(settings.settings[i].path);
    answer["keys"] = keys_json(config::load_as_written(options_.config, {}, files_));
    answer["undo_save"] = std::filesystem::exists(kept_beside(options_.config));
    reply(request_id, std::move(answer));
  });
}

void PageRequests::reply_of_axis(const RequestId& request_id, const json& request,
                                 json (*make)(const config::AxisConfig& axis, double cycle_s)) {
  const std::string axis = text_of(request, "axis");
  with_settings(request_id, [this, request_id, axis, make](const SettingsAnswer& settings) {
    require_the_same_file(settings);
    const config::Config config = config::load(options_.config, overrides_of(settings.unsaved), files_);
    json made = make(config.axes[index_of_axis(config, axis)], 1.0 / config.controller.rate_Hz);
    made["ok"] = true;
    reply(request_id, std::move(made));
  });
}

void PageRequests::bode(PageClient&, const RequestId& request_id, const json& request) {
  reply_of_axis(request_id, request, bode_of);
}

void PageRequests::curves(PageClient&, const RequestId& request_id, const json& request) {
  reply_of_axis(request_id, request, reference_curves_of);
}

void PageRequests::trigger(PageClient& client, const RequestId& request_id, const json& request) {
  if (!controller_.is_there()) return refuse(request_id, "the controller sends no cycles to capture");
  client.trigger.emplace(request, controller_.greeting());
  reply(request_id, {{"ok", true}});
}

void PageRequests::untrigger(PageClient& client, const RequestId& request_id, const json&) {
  client.trigger.reset();
  reply(request_id, {{"ok", true}});
}

void PageRequests::take_writer(PageClient& client, const RequestId& request_id, const json& request) {
  const bool is_forced = request.contains("force") && request.at("force") == true;
  if (!role_.is_free() && !role_.is_of(client) && !is_forced)
    return refuse(request_id,
                  "another page has the writer's role, so only that page can change something; "
                  "\"force\": true takes the role from it");
  role_.give_to(client.number);
  reply(request_id, {{"ok", true}});
}

void PageRequests::release_writer(PageClient& client, const RequestId& request_id, const json&) {
  if (role_.is_of(client)) role_.give_to(0);
  reply(request_id, {{"ok", true}});
}

void PageRequests::command(PageClient& client, const RequestId& request_id, const json& request) {
  const auto command = request.find("command");
  if (command == request.end() || !command->is_object())
    return refuse(request_id, "\"command\" is missing, expected a command of the control socket");
  const std::string what = text_of(*command, "do");
  const ControlCommand* row = find_command(*command, Server::controller);
  if (row == nullptr || row->page_place == 0)
    return refuse(request_id,
                  fmt::format("\"{}\" is not a command of the page, expected {}", what, page_commands()));
  if (row->access != Access::ends && !role_.is_of(client)) return refuse(request_id, no_role);
  spdlog::info("page {}: {}", request_id.client,
               command->dump(-1, ' ', true, json::error_handler_t::replace));
  role_.command(request_id.client, *command, [this, request_id](const json& answer) {
    json body{{"ok", is_done(answer)}, {"answer", answer}};
    if (!is_done(answer)) body["error"] = read_object<RefusedAnswer>(answer).error;
    reply(request_id, std::move(body));
  });
}

void PageRequests::stop(PageClient&, const RequestId& request_id, const json&) {
  spdlog::warn("page {}: stop", request_id.client);
  role_.command(request_id.client, command_of(Verb::stop),
                [this, request_id](const json& answer) { reply(request_id, answer); });
}

void PageRequests::start(PageClient&, const RequestId& request_id, const json&) {
  if (!options_.start_again)
    return refuse(request_id,
                  fmt::format("only a demo can be started from its page; start the controller with {}",
                              options_.start_command));
  options_.start_again();
  spdlog::info("page {}: start again", request_id.client);
  events_.add_act(request_id.client, "info", "start again");
  reply(request_id, {{"ok", true}});
}

void PageRequests::save(PageClient&, const RequestId& request_id, const json& request) {
  reply_or_write(request_id, request, [this](const SettingsAnswer& settings) {
    return save_of(options_.config, settings.unsaved);
  });
}

void PageRequests::undo_save(PageClient&, const RequestId& request_id, const json& request) {
  reply_or_write(
      request_id, request, [this](const SettingsAnswer&) { return undo_of(options_.config); }, false);
}

void PageRequests::reply_or_write(const RequestId& request_id, const json& request,
                                  std::function<ConfigSave(const SettingsAnswer&)> make,
                                  bool needs_valid_file) {
  const std::string digest = request.contains("digest") ? text_of(request, "digest") : "";
  with_settings(
      request_id,
      [this, request_id, digest, make = std::move(make)](const SettingsAnswer& settings) {
        require_the_same_file(settings);
        const ConfigSave save = make(settings);
        json body{{"ok", true}, {"kept", kept_beside(options_.config).filename().string()}};
        if (digest.empty()) {
          body.update({{"diff", save.diff}, {"digest", save.digest}});
          return reply(request_id, std::move(body));
        }
        if (digest != save.digest)
          return refuse(
              request_id,
              "the file or the settings changed after the difference was shown; look at the new difference");
        write_save(options_.config, save);
        const std::string done =
            fmt::format("{} {}", save.undoes ? "undo save of" : "save", options_.config.filename().string());
        spdlog::info("page {}: {}", request_id.client, done);
        events_.add_act(request_id.client, "info", done);
        if (!save.undoes) return reply(request_id, std::move(body));
        // Requests a reload, so that the controller applies the restored file. If the controller refuses the
        // reload, the reason is sent to the client as `not_applied`.
        role_.command(request_id.client, command_of(Verb::reload),
                      [this, request_id, body = std::move(body)](const json& reloaded) mutable {
                        if (!is_done(reloaded))
                          body["not_applied"] = read_object<RefusedAnswer>(reloaded).error;
                        reply(request_id, std::move(body));
                      });
      },
      needs_valid_file);
}

}  // namespace hystcan::app
