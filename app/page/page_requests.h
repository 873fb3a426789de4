// What the clients of the page ask for. docs/page_protocol.md has the requests.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "app/page/bus_counters.h"
#include "app/page/config_save.h"
#include "app/page/page_access.h"
#include "app/page/page_clients.h"
#include "app/page/page_events.h"
#include "app/page/page_stream.h"
#include "app/page/writer_role.h"
#include "config/schema/config.h"

namespace hystcan::app {

struct PageOptions {
  std::filesystem::path config;
  std::string source = "controller";  ///< or "demo"
  std::string interface {};           ///< empty: simulated
  AverageFrames frames{};
  bool exposed = false;
  std::string start_command{};
  std::function<std::filesystem::path()> controller_socket, twin_socket;
  std::chrono::seconds answer_limit{5};  ///< time for the controller to answer a command
  std::function<void()> start_again{};   ///< of a demo: begins another rehearsal, or throws why it cannot
};

/// Work that takes the page's thread for a while: one piece at a time, the clients in turn, and at most half
/// of the time. What comes five times a second, and stopping, does not wait behind it.
class RequestQueue {
 public:
  using Done = std::function<void()>;
  /// Calls `done` once, now or later.
  using Work = std::function<void(Done done)>;

  static constexpr std::size_t most_of_a_client = 16;

  explicit RequestQueue(boost::asio::io_context& context) : pause_(context) {}

  /// False if so many of this client wait already.
  [[nodiscard]] bool add(std::uint64_t client, Work work);
  void leave(std::uint64_t client) { waiting_.erase(client); }

 private:
  void next();

  boost::asio::steady_timer pause_;
  std::map<std::uint64_t, std::deque<Work>> waiting_;  ///< none is empty
  std::uint64_t served_last_ = 0;
  bool is_busy_ = false;
};

class PageRequests {
 public:
  PageRequests(boost::asio::io_context& context, const PageOptions& options, const PageAccess& access,
               PageClients& clients, PageEvents& events, const PageStream& controller, WriterRole& role);

  void receive(PageClient& client, std::string_view text);
  void leave(const PageClient& client) { queue_.leave(client.number); }

 private:
  struct Asked {
    std::uint64_t client;
    nlohmann::json id;
  };
  using Request = void (PageRequests::*)(PageClient&, const Asked&, const nlohmann::json&);

  void obey(PageClient& client, const Asked& asked, const nlohmann::json& request);
  void reply(const Asked& asked, nlohmann::json answer);
  void refuse(const Asked& asked, const std::string& reason);

  void token(PageClient&, const Asked&, const nlohmann::json&);
  void view(PageClient&, const Asked&, const nlohmann::json&);
  void settings(PageClient&, const Asked&, const nlohmann::json&);
  void bode(PageClient&, const Asked&, const nlohmann::json&);
  void curves(PageClient&, const Asked&, const nlohmann::json&);
  void trigger(PageClient&, const Asked&, const nlohmann::json&);
  void untrigger(PageClient&, const Asked&, const nlohmann::json&);
  void take_writer(PageClient&, const Asked&, const nlohmann::json&);
  void release_writer(PageClient&, const Asked&, const nlohmann::json&);
  void command(PageClient&, const Asked&, const nlohmann::json&);
  void stop(PageClient&, const Asked&, const nlohmann::json&);
  void start(PageClient&, const Asked&, const nlohmann::json&);
  void save(PageClient&, const Asked&, const nlohmann::json&);
  void undo_save(PageClient&, const Asked&, const nlohmann::json&);

  /// `work` is called with the answer to `settings`, when it is this client's turn.
  void with_settings(const Asked& asked, std::function<void(const nlohmann::json& settings)> work,
                     bool needs_valid_file = true);
  /// Replies with what `make` makes of the axis with the settings in force.
  void reply_of_axis(const Asked& asked, const nlohmann::json& request,
                     nlohmann::json (*make)(const config::AxisConfig& axis, double cycle_s));
  /// Replies with the difference; if the request has its digest, writes the file.
  void reply_or_write(const Asked& asked, const nlohmann::json& request,
                      std::function<ConfigSave(const nlohmann::json& settings)> make,
                      bool needs_valid_file = true);
  void require_the_same_file(const nlohmann::json& settings) const;

  boost::asio::io_context& context_;
  const PageOptions& options_;
  const PageAccess& access_;
  PageClients& clients_;
  PageEvents& events_;
  const PageStream& controller_;
  WriterRole& role_;
  RequestQueue queue_;
};

}  // namespace hystcan::app
