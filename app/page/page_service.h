// The service behind the page's server. It forwards the streams of controller and twin to the clients, and
// the clients' commands to the control socket. docs/page_protocol.md lists all messages. All code runs on one
// thread. A lane contains the rows of a stream, reduced to the rate that some of the clients requested.
//
//   PageStream (controller, twin) ──▶ PageEvents, captures, lanes ──▶ PageClients
//   PageClients ──▶ PageRequests ──▶ WriterRole ──▶ ControlLink ──▶ control socket
//
// There are three connections to a controller. The first one is the stream of rows; it accepts no commands,
// and the controller never waits until this process has read the rows. The second one is for commands. The
// third one is only for `stop` and `disable`, and is closed after their answer.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <optional>
#include <span>
#include <string_view>

#include "app/live/control_answers.h"
#include "app/page/bus_counters.h"
#include "app/page/control_link.h"
#include "app/page/http_server.h"
#include "app/page/page_access.h"
#include "app/page/page_clients.h"
#include "app/page/page_events.h"
#include "app/page/page_requests.h"
#include "app/page/page_stream.h"
#include "app/page/writer_role.h"

namespace hystcan::app {

class PageService {
 public:
  PageService(boost::asio::io_context& context, PageOptions options, PageAccess access);

  /// Returns the response to an HTTP request that does not open a WebSocket.
  HttpResponse answer(const HttpRequest& request);
  /// Returns status 101 if the client may open a WebSocket; otherwise the response that refuses the request.
  HttpResponse admit(const HttpRequest& request);

  void opened(WebClient& web);
  void received(WebClient& web, std::string_view text);
  void closed(WebClient& web);
  /// Disconnects the oldest client without a valid token, to make room for a new connection. Returns false if
  /// all clients have a valid token.
  bool make_room() { return clients_.make_room(); }
  /// Counts a client that the server disconnected, or a connection beyond the limit.
  void count_cut_off() { ++clients_.counters.cut_off; }

 private:
  HttpResponse judge(const HttpRequest& request);
  void send_stream(PageClient& client, const PageStream& stream);
  void stream_changed(const PageStream& stream);
  void row_of_controller(std::span<const double> row);
  void batch(PageStream& stream, std::uint32_t lost);
  void send_rows(PageClient& client, const PageStream& stream, const RowBlock& rows);
  void send_capture(PageClient& client, const Capture& capture);
  void look();  ///< requests the status of the controller, five times a second
  void send_status();
  /// Returns the time in s since the controller's last answer; infinite before the first answer.
  double status_age_s() const;
  /// Returns the status of the controller; nullopt if it has not answered, or if its last answer is too old.
  std::optional<StatusAnswer> status_known() const;

  PageOptions options_;
  PageAccess access_;
  PageClients clients_;
  PageEvents events_{clients_};
  PageStream controller_, twin_;
  ControlLink link_, ending_;
  WriterRole role_;
  PageRequests requests_;
  std::uint32_t next_capture_ = 1;

  boost::asio::steady_timer timer_;
  BusCounters bus_;
  BusReport bus_report_{};
  std::optional<StatusAnswer> status_;
  bool looks_ = false;  ///< true while a request for `status` waits for its answer
  std::optional<std::chrono::steady_clock::time_point> status_came_;
};

}  // namespace hystcan::app
