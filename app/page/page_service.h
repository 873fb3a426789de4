// The operator's page behind its server: passes the streams on to the clients, and their commands to the control socket.
// docs/page_protocol.md has all messages. One thread.
//
//   PageStream (controller, twin) ──▶ CycleWatch, captures, lanes ──▶ clients
//   clients ──▶ requests (page_requests.cpp) ──▶ RequestQueue ──▶ ControlLink ──▶ control socket
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/page/bus_counters.h"
#include "app/page/capture.h"
#include "app/page/config_save.h"
#include "app/page/control_link.h"
#include "app/page/cycle_watch.h"
#include "app/page/http_server.h"
#include "app/page/open_metrics.h"
#include "app/page/page_access.h"
#include "app/page/page_stream.h"
#include "app/page/request_queue.h"
#include "app/page/stream_source.h"
#include "config/schema/config.h"

namespace hystcan::app {

struct PageOptions {
  std::filesystem::path config;
  std::string source = "controller";  ///< or "demo"
  std::string interface {};           ///< empty: simulated
  double bitrate_bit_per_s = 0.0;     ///< 0: not known
  bool exposed = false;
  std::string start_command{};
  std::function<std::filesystem::path()> controller_socket, twin_socket;
  std::function<void()> start_again{};  ///< of a demo: begins another rehearsal, or throws why it cannot
};

class PageService final : public PageHandler {
 public:
  PageService(boost::asio::io_context& context, PageOptions options, PageAccess access);

  HttpResponse answer(const HttpRequest& request) override;
  HttpResponse admit(const HttpRequest& request) override;
  void opened(WebClient& client) override;
  void received(WebClient& client, std::string_view text) override;
  void closed(WebClient& client) override;
  bool make_room() override;
  void count_cut_off() override { ++counters_.cut_off; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Client {
    WebClient& web;
    std::uint64_t number;
    bool is_authorised = false;
    bool waits_for_token = false;                   ///< the answer to a wrong one is under way
    double rate = 500.0;                            ///< rows per axis and second
    std::map<std::uint32_t, std::uint32_t> lost{};  ///< rows of each kind since the last message
    std::optional<CaptureTrigger> trigger{};
    Clock::time_point second{};  ///< begin of the second in which messages are counted
    int messages = 0;
  };
  struct Asked {
    std::uint64_t client;
    nlohmann::json id;
  };
  using Request = void (PageService::*)(Client&, const Asked&, const nlohmann::json&);

  HttpResponse judge(const HttpRequest& request);
  /// Null if it has left.
  Client* client_with(std::uint64_t number);
  void greet(Client& client);
  void send_stream(Client& client, const PageStream& stream);
  void stream_changed(const PageStream& stream);
  void row_of_controller(std::span<const double> row);
  void batch(const PageStream& stream, std::uint32_t lost);
  void send_rows(Client& client, const PageStream& stream, const RowBlock& rows);
  void send_capture(Client& client, const Capture& capture);
  void set_rates();
  void look();  ///< asks for the state, five times a second
  void send_status();
  /// Seconds since the last answer; infinite before the first.
  double status_age_s() const;
  /// The state of the controller; null if it does not answer, or if the last answers that were due have not come.
  const nlohmann::json& status_known() const;
  void send_writer(Client& client) const;
  void broadcast(const nlohmann::json& message);
  /// To all pages, and to those that come later.
  void tell_all(const std::vector<nlohmann::json>& events);
  void command_answered(const std::string& by, const nlohmann::json& command, const nlohmann::json& answer);
  /// Tells of settings that no command of a page has changed.
  void compare_settings(const nlohmann::json& settings);

  void reply(const Asked& asked, nlohmann::json answer);
  void refuse(const Asked& asked, const std::string& reason);
  bool is_too_much(Client& client) const;
  void obey(Client& client, const Asked& asked, const nlohmann::json& request);

  void token(Client&, const Asked&, const nlohmann::json&);
  void view(Client&, const Asked&, const nlohmann::json&);
  void settings(Client&, const Asked&, const nlohmann::json&);
  /// `work` is called with the answer to `settings`, when it is this client's turn.
  void with_settings(const Asked& asked, std::function<void(const nlohmann::json& settings)> work);
  using MakeOfAxis = std::function<nlohmann::json(const config::Config&, const config::AxisConfig&)>;
  void reply_of_axis(const Asked& asked, const nlohmann::json& request, const MakeOfAxis& make);
  void curves(Client&, const Asked&, const nlohmann::json&);
  void bode(Client&, const Asked&, const nlohmann::json&);
  void trigger(Client&, const Asked&, const nlohmann::json&);
  void untrigger(Client&, const Asked&, const nlohmann::json&);
  void take_writer(Client&, const Asked&, const nlohmann::json&);
  void release_writer(Client&, const Asked&, const nlohmann::json&);
  void command(Client&, const Asked&, const nlohmann::json&);
  void stop(Client&, const Asked&, const nlohmann::json&);
  void start(Client&, const Asked&, const nlohmann::json&);
  void save(Client&, const Asked&, const nlohmann::json&);
  void undo_save(Client&, const Asked&, const nlohmann::json&);
  using MakeSave = std::function<ConfigSave(const nlohmann::json& settings)>;
  void reply_or_write(const Asked& asked, const nlohmann::json& request, const MakeSave& make);
  void reload_restored(const Asked& asked, nlohmann::json told);
  void give_role_to(std::uint64_t client);
  void require_the_same_file(const nlohmann::json& settings) const;

  PageOptions options_;
  PageAccess access_;
  PageCounters counters_;
  std::map<WebClient*, Client> clients_;
  std::uint64_t next_client_ = 1;
  std::uint64_t writer_ = 0;  ///< number of the client that has the role; 0: none
  std::uint32_t next_capture_ = 1;
  std::map<std::string, std::string> known_settings_;  ///< of the running controller; empty if not known yet
  std::uint64_t changes_ = 0;                          ///< commands that were passed on, and their answers

  CycleWatch watch_;
  PageStream controller_, twin_;
  BusCounters bus_;
  nlohmann::json status_, bus_report_;
  std::optional<Clock::time_point> status_came_;
  boost::asio::steady_timer timer_;
  boost::asio::io_context& context_;
  ControlLink looking_, reading_, writing_, stopping_;
  RequestQueue slow_requests_;
  StreamSource controller_source_, twin_source_;
};

}  // namespace hystcan::app
