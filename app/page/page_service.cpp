#include "app/page/page_service.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "app/live/answer_json.h"
#include "app/live/control_protocol.h"
#include "app/page/assets.h"
#include "app/page/open_metrics.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

constexpr auto time_between_looks = std::chrono::milliseconds(200);
// Maximum age in s of a status that is still shown. An answer normally arrives every 0.2 s. At this age, at
// least two answers are therefore missing.
constexpr double longest_age_s = 0.6;
constexpr std::uint32_t capture_kind = 3;

}  // namespace

PageService::PageService(boost::asio::io_context& context, PageOptions options, PageAccess access)
    : options_(std::move(options)),
      access_(std::move(access)),
      controller_(context, "controller", 1, options_.controller_socket,
                  {.changed = [this] { stream_changed(controller_); },
                   .row = [this](std::span<const double> row) { row_of_controller(row); },
                   .batch = [this](std::uint32_t lost) { batch(controller_, lost); }}),
      twin_(context, "twin", 2, options_.twin_socket,
            {.changed = [this] { stream_changed(twin_); },
             .row = [](std::span<const double>) {},
             .batch = [this](std::uint32_t lost) { batch(twin_, lost); }}),
      link_(context, options_.controller_socket, options_.answer_limit),
      ending_(context, options_.controller_socket, options_.answer_limit),
      role_(link_, ending_, clients_, events_),
      requests_(context, options_, access_, clients_, events_, controller_, role_),
      timer_(context),
      bus_(options_.interface, options_.frames) {
  look();
}

HttpResponse PageService::judge(const HttpRequest& request) {
  HttpResponse judged = access_.judge(request);
  if (judged.status != 200) ++clients_.counters.refused;
  return judged;
}

HttpResponse PageService::answer(const HttpRequest& request) {
  if (HttpResponse judged = judge(request); judged.status != 200) return judged;
  if (request.method != "GET" && request.method != "HEAD")
    return {.status = 405, .body = "Only GET is allowed.\n"};
  const std::string path = request.target.substr(0, request.target.find('?'));
  if (path == "/metrics") {
    const bool is_open = accepts_open_metrics(request.accept);
    return {.type = metrics_type(is_open),
            .body = metrics_text(is_open, status_known(), status_age_s(), bus_report_,
                                 events_.turnaround_us(), events_.lateness_us(), clients_.counters)};
  }
  if (path == "/socket") return {.status = 426, .body = "This is a WebSocket.\n"};
  for (const Asset& asset : page_assets())
    if (asset.path == path) return {.type = std::string(asset.type), .body = std::string(asset.content)};
  return {.status = 404, .body = "The file does not exist.\n"};
}

HttpResponse PageService::admit(const HttpRequest& request) {
  if (HttpResponse judged = judge(request); judged.status != 200) return judged;
  if (request.target != "/socket") return {.status = 404, .body = "The WebSocket is at /socket.\n"};
  return {.status = 101};
}

void PageService::opened(WebClient& web) {
  PageClient& client = clients_.add(web);
  client.send({{"type", "hello"},
               {"version", 1},
               {"page", client.number},
               {"program", "hystcan"},
               {"config", options_.config.filename().string()},
               {"source", options_.source},
               {"exposed", options_.exposed},
               {"start_command", options_.start_command}});
  role_.show_to(client);
  for (const PageStream* stream : {&controller_, &twin_}) send_stream(client, *stream);
  for (const json& event : events_.newest()) client.send(event);
}

void PageService::received(WebClient& web, std::string_view text) {
  if (PageClient* client = clients_.of(web)) requests_.receive(*client, text);
}

void PageService::closed(WebClient& web) {
  const PageClient* client = clients_.of(web);
  if (client == nullptr) return;
  const bool had_role = role_.is_of(*client);
  requests_.leave(*client);
  clients_.remove(*client);
  if (had_role) role_.give_to(0);
}

void PageService::send_stream(PageClient& client, const PageStream& stream) {
  client.send(stream.message());
  if (!stream.is_there()) return;
  client.lost[stream.kind()] = 0;
  for (const RowBlock& block : stream.past()) send_rows(client, stream, block);
}

void PageService::stream_changed(const PageStream& stream) {
  if (&stream == &controller_) {
    if (stream.is_there()) events_.begin(stream.greeting());
    for (auto& [number, client] : clients_.all()) client.trigger.reset();
    role_.controller_changed();
  }
  for (auto& [number, client] : clients_.all()) send_stream(client, stream);
}

void PageService::row_of_controller(std::span<const double> row) {
  events_.put(row);
  for (auto& [number, client] : clients_.all()) {
    if (!client.trigger) continue;
    const auto capture = client.trigger->put(row, controller_.history());
    if (!capture) continue;
    // A client that is too slow gets no capture. Its trigger waits for the next event.
    if (!client.web.takes_rows()) continue;
    send_capture(client, *capture);
    if (!client.trigger->repeats()) client.trigger.reset();
  }
}

void PageService::batch(PageStream& stream, std::uint32_t lost_rows) {
  for (auto& [number, client] : clients_.all()) {
    client.lost[stream.kind()] += lost_rows;
    if (const RowBlock rows = stream.rows_at(client.rate)) send_rows(client, stream, rows);
  }
}

void PageService::send_rows(PageClient& client, const PageStream& stream, const RowBlock& rows) {
  const auto count = static_cast<std::uint32_t>(rows->size() / stream.history().columns());
  std::uint32_t& lost_rows = client.lost[stream.kind()];
  if (client.web.send_rows({stream.kind(), count, lost_rows, 0}, rows)) {
    lost_rows = 0;
  } else {
    lost_rows += count;
    clients_.counters.lost_rows += count;
  }
}

void PageService::send_capture(PageClient& client, const Capture& capture) {
  const Trigger& trigger = *client.trigger;
  const std::uint32_t number = next_capture_++;
  const StreamAxis& axis = controller_.greeting().axes[trigger.axis()];
  const auto rows = static_cast<std::uint32_t>(capture.rows.size() / controller_.history().columns());
  client.send({{"type", "capture"},
               {"number", number},
               {"on", trigger.name()},
               {"axis", trigger.axis()},
               {"trigger_row", capture.trigger_row},
               {"trigger_time_s", capture.trigger_time_s},
               {"step", step_of(capture, events_.columns(), axis.tolerance_um.value_or(0.0))},
               {"stream", "controller"}});
  client.web.send_rows({capture_kind, rows, 0, number},
                       std::make_shared<const std::vector<double>>(capture.rows));
}

void PageService::look() {
  timer_.expires_after(time_between_looks);
  timer_.async_wait([this](const boost::system::error_code& cancelled) {
    if (!cancelled) look();
  });
  bus_report_ = bus_.report();
  if (looks_) {
    if (status_age_s() > longest_age_s) send_status();
    return;
  }
  looks_ = true;
  link_.ask(command_of(Verb::status), [this](const json& answer) {
    looks_ = false;
    status_.reset();
    status_came_ = std::chrono::steady_clock::now();
    try {
      status_ = read_answer<StatusAnswer>(answer);
    } catch (const RunError&) {  // the answer is a refusal: no controller is running
    }
    send_status();
  });
}

double PageService::status_age_s() const {
  return status_came_
             ? std::chrono::duration<double>(std::chrono::steady_clock::now() - *status_came_).count()
             : std::numeric_limits<double>::infinity();
}

std::optional<StatusAnswer> PageService::status_known() const {
  return status_age_s() <= longest_age_s ? status_ : std::nullopt;
}

void PageService::send_status() {
  const PageCounters& counters = clients_.counters;
  const std::optional<StatusAnswer> known = status_known();
  clients_.send_all({{"type", "status"},
                     {"controller", known ? answer_json(*known) : json()},
                     {"age_s", status_came_ ? json(status_age_s()) : json()},
                     {"bus", as_json(bus_report_)},
                     {"timing",
                      {{"upper_us", events_.turnaround_us().upper_edges()},
                       {"turnaround_us", events_.turnaround_us().counts()},
                       {"lateness_us", events_.lateness_us().counts()}}},
                     {"page",
                      {{"clients", counters.clients},
                       {"cut_off", counters.cut_off},
                       {"refused", counters.refused},
                       {"lost_rows", counters.lost_rows}}}});
}

}  // namespace hystcan::app
