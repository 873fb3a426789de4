// The browsers that are connected to the page's WebSocket.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/page/capture.h"
#include "app/page/http_server.h"

namespace hystcan::app {

struct PageClient {
  WebClient& web;
  std::uint64_t number;
  bool is_authorised = false;
  bool waits_for_token = false;                   ///< the delayed answer to a wrong token is pending
  double rate = 500.0;                            ///< requested rate: rows per axis and second
  std::map<std::uint32_t, std::uint32_t> lost{};  ///< rows dropped since the last message, by stream
  std::optional<Trigger> trigger{};
  std::chrono::steady_clock::time_point second{};  ///< start of the second in which `messages` are counted
  int messages = 0;

  void send(const nlohmann::json& message) {
    web.send_text(message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  /// Counts a message of the client. Returns true if the client sent too many messages in this second.
  bool sends_too_much();
};

struct PageCounters {
  std::uint64_t clients = 0;
  std::uint64_t cut_off = 0;
  std::uint64_t refused = 0;
  std::uint64_t lost_rows = 0;
};

class PageClients {
 public:
  PageClient& add(WebClient& web);
  void remove(const PageClient& client);
  /// Returns the client of this WebSocket; null if it has disconnected.
  PageClient* of(const WebClient& web);
  PageClient* with(std::uint64_t number);
  /// Returns all clients, sorted by number. The oldest client has the smallest number.
  std::map<std::uint64_t, PageClient>& all() { return clients_; }
  void send_all(const nlohmann::json& message);
  /// Disconnects the oldest client without a valid token. Returns false if all clients have a valid token.
  bool make_room();

  PageCounters counters;

 private:
  std::map<std::uint64_t, PageClient> clients_;
  std::uint64_t next_ = 1;
};

}  // namespace hystcan::app
