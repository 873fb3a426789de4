// Handles the requests of the page's clients. docs/page_protocol.md lists the requests.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "app/live/control_answers.h"
#include "app/page/config_save.h"
#include "app/page/page_access.h"
#include "app/page/page_clients.h"
#include "app/page/page_events.h"
#include "app/page/page_options.h"
#include "app/page/page_stream.h"
#include "app/page/request_queue.h"
#include "app/page/writer_role.h"
#include "config/schema/config.h"

namespace hystcan::app {

class PageRequests {
 public:
  PageRequests(boost::asio::io_context& context, const PageOptions& options, const PageAccess& access,
               PageClients& clients, PageEvents& events, const PageStream& controller, WriterRole& role);

  void receive(PageClient& client, std::string_view text);
  void leave(const PageClient& client) { queue_.leave(client.number); }

 private:
  struct RequestId {
    std::uint64_t client;
    nlohmann::json id;
  };
  using Request = void (PageRequests::*)(PageClient&, const RequestId&, const nlohmann::json&);

  void dispatch(PageClient& client, const RequestId& request_id, const nlohmann::json& request);
  void reply(const RequestId& request_id, nlohmann::json answer);
  void refuse(const RequestId& request_id, const std::string& reason);

  void token(PageClient&, const RequestId&, const nlohmann::json&);
  void view(PageClient&, const RequestId&, const nlohmann::json&);
  void settings(PageClient&, const RequestId&, const nlohmann::json&);
  void bode(PageClient&, const RequestId&, const nlohmann::json&);
  void curves(PageClient&, const RequestId&, const nlohmann::json&);
  void trigger(PageClient&, const RequestId&, const nlohmann::json&);
  void untrigger(PageClient&, const RequestId&, const nlohmann::json&);
  void take_writer(PageClient&, const RequestId&, const nlohmann::json&);
  void release_writer(PageClient&, const RequestId&, const nlohmann::json&);
  void command(PageClient&, const RequestId&, const nlohmann::json&);
  void stop(PageClient&, const RequestId&, const nlohmann::json&);
  void start(PageClient&, const RequestId&, const nlohmann::json&);
  void save(PageClient&, const RequestId&, const nlohmann::json&);
  void undo_save(PageClient&, const RequestId&, const nlohmann::json&);

  /// When it is this client's turn in the queue, requests the settings from the controller and calls `work`
  /// with the answer. If the configuration file is invalid, there are two cases. If `needs_valid_file` is
  /// true, the client gets a refusal and `work` is not called. Otherwise, `work` is called with an answer in
  /// which only the member `file` is set.
  void with_settings(const RequestId& request_id, std::function<void(const SettingsAnswer&)> work,
                     bool needs_valid_file = true);
  /// Calls `make` with the configuration in force of the requested axis, and sends the result to the client.
  void reply_of_axis(const RequestId& request_id, const nlohmann::json& request,
                     nlohmann::json (*make)(const config::AxisConfig& axis, double cycle_s));
  /// Saves the configuration file in two steps. A request without `digest` gets the difference between the
  /// current and the new text, and its digest. A request with this digest writes the new text.
  void reply_or_write(const RequestId& request_id, const nlohmann::json& request,
                      std::function<ConfigSave(const SettingsAnswer&)> make, bool needs_valid_file = true);
  void require_the_same_file(const SettingsAnswer& settings) const;

  boost::asio::io_context& context_;
  const PageOptions& options_;
  const PageAccess& access_;
  PageClients& clients_;
  PageEvents& events_;
  const PageStream& controller_;
  WriterRole& role_;
  RequestQueue queue_;
  config::ReadFiles files_;
};

}  // namespace hystcan::app
