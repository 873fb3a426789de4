#include "app/page/page_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "app/live/sample_stream.h"
#include "app/page/assets.h"
#include "app/page/command_event.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

constexpr auto time_between_looks = std::chrono::milliseconds(200);
constexpr double longest_age_s = 0.6;  // two answers that were due have not come
constexpr std::uint32_t capture_kind = 3;

std::string text_of_message(const json& message) {
  return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

json to_json(const TimingHistogram& times) { return times.counts(); }

}  // namespace

PageService::PageService(boost::asio::io_context& context, PageOptions options, PageAccess access)
    : options_(std::move(options)),
      access_(std::move(access)),
      controller_("controller", 1,
                  {.changed = [this] { stream_changed(controller_); },
                   .row = [this](std::span<const double> row) { row_of_controller(row); },
                   .batch = [this](std::uint32_t lost) { batch(controller_, lost); }}),
      twin_("twin", 2,
            {.changed = [this] { stream_changed(twin_); },
             .row = [](std::span<const double>) {},
             .batch = [this](std::uint32_t lost) { batch(twin_, lost); }}),
      bus_(options_.interface, options_.bitrate_bit_per_s),
      timer_(context),
      context_(context),
      looking_(context, options_.controller_socket),
      reading_(context, options_.controller_socket),
      writing_(context, options_.controller_socket),
      stopping_(context, options_.controller_socket),
      slow_requests_(context),
      controller_source_(
          context, [this] { return stream_beside(options_.controller_socket()); }, controller_),
      twin_source_(
          context, [this] { return stream_beside(options_.twin_socket()); }, twin_) {
  look();
}

HttpResponse PageService::judge(const HttpRequest& request) {
  HttpResponse judged = access_.judge(request);
  if (judged.status != 200) ++counters_.refused;
  return judged;
}

HttpResponse PageService::answer(const HttpRequest& request) {
  if (HttpResponse judged = judge(request); judged.status != 200) return judged;
  if (request.method != "GET" && request.method != "HEAD")
    return {.status = 405, .body = "Nothing changes by HTTP; expected GET.\n"};
  const std::string path = request.target.substr(0, request.target.find('?'));
  if (path == "/metrics") {
    const json states = controller_.is_there() ? controller_.greeting().value("states", json()) : json();
    const MetricsFormat format = metrics_format_for(request.accept);
    return {.type = content_type(format),
            .body = metrics_text(format, {status_known(), status_age_s()}, states, bus_report_,
                                 watch_.turnaround(), watch_.lateness(), counters_)};
  }
  if (path == "/socket") return {.status = 426, .body = "This is a WebSocket.\n"};
  for (const Asset& asset : page_assets())
    if (asset.path == path) return {.type = std::string(asset.type), .body = std::string(asset.content)};
  return {.status = 404, .body = "There is no such file.\n"};
}

HttpResponse PageService::admit(const HttpRequest& request) {
  if (HttpResponse judged = judge(request); judged.status != 200) return judged;
  if (request.target != "/socket") return {.status = 404, .body = "The WebSocket is at /socket.\n"};
  return {.status = 101};
}

void PageService::opened(WebClient& web) {
  Client& client = clients_.emplace(&web, Client{.web = web, .number = next_client_++}).first->second;
  counters_.clients = clients_.size();
  set_rates();
  greet(client);
}

void PageService::closed(WebClient& web) {
  const auto found = clients_.find(&web);
  if (found == clients_.end()) return;
  const bool had_role = found->second.number == writer_;
  slow_requests_.leave(found->second.number);
  clients_.erase(found);
  counters_.clients = clients_.size();
  set_rates();
  if (had_role) give_role_to(0);
}

bool PageService::make_room() {
  Client* oldest = nullptr;
  for (auto& [web, client] : clients_)
    if (!client.is_authorised && (oldest == nullptr || client.number < oldest->number)) oldest = &client;
  if (oldest == nullptr) return false;
  oldest->web.cut_off();
  return true;
}

void PageService::greet(Client& client) {
  client.web.send_text(text_of_message({{"type", "hello"},
                                        {"version", 1},
                                        {"page", client.number},
                                        {"program", "hystcan"},
                                        {"config", options_.config.filename().string()},
                                        {"source", options_.source},
                                        {"exposed", options_.exposed},
                                        {"start_command", options_.start_command}}));
  send_writer(client);
  for (const PageStream* stream : {&controller_, &twin_}) send_stream(client, *stream);
  for (const json& event : watch_.events()) client.web.send_text(text_of_message(event));
}

void PageService::send_stream(Client& client, const PageStream& stream) {
  client.web.send_text(text_of_message(stream.message()));
  if (!stream.is_there()) return;
  client.lost[stream.kind()] = 0;
  for (const RowBlock& block : stream.past()) send_rows(client, stream, block);
}

void PageService::stream_changed(const PageStream& stream) {
  if (&stream == &controller_) {
    if (stream.is_there()) watch_.begin(stream.greeting());
    for (auto& [web, client] : clients_) client.trigger.reset();
    known_settings_.clear();
    for (ControlLink* link : {&reading_, &writing_})  // its other end may be gone with the controller
      if (!link->is_busy()) link->close();
  }
  for (auto& [web, client] : clients_) send_stream(client, stream);
}

void PageService::row_of_controller(std::span<const double> row) {
  if (const auto event = watch_.put(row)) broadcast(*event);
  for (auto& [web, client] : clients_) {
    if (!client.trigger) continue;
    const auto capture = client.trigger->put(row, controller_.history());
    if (!capture) continue;
    send_capture(client, *capture);
    if (!client.trigger->trigger().repeat) client.trigger.reset();
  }
}

void PageService::batch(const PageStream& stream, std::uint32_t lost) {
  for (auto& [web, client] : clients_) {
    client.lost[stream.kind()] += lost;
    if (const RowBlock rows = stream.rows_at(client.rate)) send_rows(client, stream, rows);
  }
}

void PageService::send_rows(Client& client, const PageStream& stream, const RowBlock& rows) {
  const auto count = static_cast<std::uint32_t>(rows->size() / stream.history().columns());
  std::uint32_t& lost = client.lost[stream.kind()];
  if (client.web.send_rows({stream.kind(), count, lost, 0}, rows)) {
    lost = 0;
  } else {
    lost += count;
    counters_.lost_rows += count;
  }
}

void PageService::send_capture(Client& client, const Capture& capture) {
  const Trigger& trigger = client.trigger->trigger();
  const std::uint32_t number = next_capture_++;
  const auto rows = static_cast<std::uint32_t>(capture.rows.size() / controller_.history().columns());
  client.web.send_text(text_of_message({{"type", "capture"},
                                        {"number", number},
                                        {"on", trigger.name},
                                        {"axis", trigger.axis},
                                        {"trigger_row", capture.trigger_row},
                                        {"trigger_time_s", capture.trigger_time_s},
                                        {"stream", "controller"}}));
  const bool is_sent = client.web.send_rows({capture_kind, rows, 0, number},
                                            std::make_shared<const std::vector<double>>(capture.rows));
  if (!is_sent) counters_.lost_rows += rows;
}

void PageService::set_rates() {
  std::set<double> rates;
  for (const auto& [web, client] : clients_) rates.insert(client.rate);
  for (PageStream* stream : {&controller_, &twin_}) stream->set_rates(rates);
}

void PageService::look() {
  timer_.expires_after(time_between_looks);
  timer_.async_wait([this](const boost::system::error_code& cancelled) {
    if (!cancelled) look();
  });
  bus_report_ = bus_.report();
  if (looking_.is_busy()) {
    if (status_age_s() > longest_age_s) send_status();
    return;
  }
  looking_.ask({{"do", "status"}}, [this](const json& answer) {
    status_ = answer;
    status_came_ = Clock::now();
    send_status();
  });
}

double PageService::status_age_s() const {
  return status_came_ ? std::chrono::duration<double>(Clock::now() - *status_came_).count()
                      : std::numeric_limits<double>::infinity();
}

const json& PageService::status_known() const {
  static const json unknown;
  return status_age_s() <= longest_age_s && status_.value("ok", false) ? status_ : unknown;
}

void PageService::send_status() {
  broadcast({{"type", "status"},
             {"controller", status_known()},
             {"age_s", status_came_ ? json(status_age_s()) : json()},
             {"bus", bus_report_},
             {"timing",
              {{"upper_us", TimingHistogram::upper_us},
               {"turnaround_us", to_json(watch_.turnaround())},
               {"lateness_us", to_json(watch_.lateness())}}},
             {"page",
              {{"clients", counters_.clients},
               {"cut_off", counters_.cut_off},
               {"refused", counters_.refused},
               {"lost_rows", counters_.lost_rows}}}});
}

void PageService::send_writer(Client& client) const {
  const char* role = writer_ == 0 ? "free" : writer_ == client.number ? "yours" : "taken";
  client.web.send_text(
      text_of_message({{"type", "writer"}, {"role", role}, {"authorised", client.is_authorised}}));
}

void PageService::broadcast(const json& message) {
  const std::string text = text_of_message(message);
  for (auto& [web, client] : clients_) client.web.send_text(text);
}

void PageService::tell_all(const std::vector<json>& events) {
  for (const json& event : events) broadcast(watch_.keep(event));
}

void PageService::command_answered(const std::string& by, const json& command, const json& answer) {
  ++changes_;
  if (const auto changed = answer.find("changed"); changed != answer.end() && !known_settings_.empty())
    for (const json& change : *changed) {
      const std::string key = change.at("key"), to = change.at("to");
      if (to.empty())
        known_settings_.erase(key);
      else
        known_settings_[key] = to;
    }
  tell_all(command_events(by, command, answer));
}

void PageService::compare_settings(const json& settings) {
  std::map<std::string, std::string> now;
  for (const json& setting : settings) now.emplace(setting.at("key"), setting.at("value"));
  json changes = json::array();
  const auto value_in = [](const std::map<std::string, std::string>& all, const std::string& key) {
    const auto found = all.find(key);
    return found == all.end() ? std::string() : found->second;
  };
  for (const auto& [key, value] : now)
    if (const std::string from = value_in(known_settings_, key); from != value)
      changes.push_back({{"key", key}, {"from", from}, {"to", value}});
  for (const auto& [key, value] : known_settings_)
    if (!now.contains(key)) changes.push_back({{"key", key}, {"from", value}, {"to", ""}});
  if (!known_settings_.empty()) tell_all(change_events("file or control socket", "set", changes));
  known_settings_ = std::move(now);
}

}  // namespace hystcan::app
