// The page's server from the side of a browser or a stranger: a running controller in virtual time, and plain
// sockets as clients. The wall clock only ends a test that hangs.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/post.hpp>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <thread>

#include "app/page/page_service.h"
#include "tests/app/page/page_bench.h"

namespace hystcan::app::page_server_test {
namespace {

using nlohmann::json;

/// Returns the next known status of the controller. The status is unknown while a busy machine delays the
/// controller's answer.
json next_controller(WebPeer& peer) {
  json controller;
  do controller = peer.next("status").at("controller");
  while (controller.is_null());
  return controller;
}

TEST_F(PageServer, AnswersItsOwnNamesOnly) {
  EXPECT_EQ(status_of("GET /metrics HTTP/1.1", "Host: 127.0.0.1:8080\r\n"), 200);
  EXPECT_EQ(status_of("GET /metrics HTTP/1.1", "Host: rebound.example\r\n"), 421);
  EXPECT_EQ(status_of("GET /metrics HTTP/1.1", ""), 421);
  EXPECT_EQ(WebPeer(server_->port()).upgrade("Host: rebound.example\r\n"), 421);
}

TEST_F(PageServer, RefusesAPageOfAnotherOrigin) {
  EXPECT_EQ(WebPeer(server_->port()).upgrade("Host: localhost\r\nOrigin: http://evil.example\r\n"), 403);
  EXPECT_EQ(WebPeer(server_->port()).upgrade("Host: localhost\r\nOrigin: null\r\n"), 403);
  EXPECT_EQ(WebPeer(server_->port()).upgrade("Host: localhost\r\nOrigin: http://localhost\r\n"), 101);
}

TEST_F(PageServer, ChangesNothingByHttp) {
  for (const char* method : {"POST", "PUT", "DELETE", "PATCH"})
    EXPECT_EQ(status_of(std::string(method) + " /metrics HTTP/1.1"), 405) << method;
  EXPECT_EQ(status_of("GET /../../etc/passwd HTTP/1.1"), 404);
  EXPECT_EQ(status_of("GET /socket HTTP/1.1"), 426);
}

TEST_F(PageServer, RefusesALongHeaderABodyAndInvalidHttp) {
  EXPECT_EQ(status_of("GET /metrics HTTP/1.1", "Host: localhost\r\nX: " + std::string(9000, 'x') + "\r\n"),
            431);
  EXPECT_EQ(status_of("POST / HTTP/1.1", "Host: localhost\r\nContent-Length: 10\r\n"), 413);
  EXPECT_EQ(status_of("\x16\x03\x01 what a TLS client says"), 400);
}

TEST_F(PageServer, SendsEveryCycleOfTheController) {
  const auto peer = page();
  EXPECT_EQ(peer->next("hello").at("config"), "piezo.toml");
  const json greeting = next_stream(*peer, "controller", true).at("greeting");
  const std::size_t columns = greeting.at("columns").size();
  EXPECT_TRUE(peer->is_ok({{"do", "view"}, {"rate_Hz", 1000}}));
  peer->next_rows(1);
  double last = 0.0;
  // A busy machine may lose rows before and after the rows of a message that reports lost ones.
  for (std::uint32_t messages = 0, lost_before = 0; messages < 20; ++messages) {
    const WebPeer::Message message = peer->next_rows(1);
    ASSERT_EQ(message.head.size(), 4u);
    EXPECT_EQ(message.rows.size(), message.head[1] * columns);
    bool is_next = last != 0.0 && lost_before == 0 && message.head[2] == 0;
    lost_before = message.head[2];
    for (std::size_t i = 0; i < message.rows.size(); i += columns) {
      if (message.rows[i + 2] != 0.0) continue;  // axis
      if (is_next) {
        EXPECT_EQ(message.rows[i], last + 1.0) << "cycle";
      }
      is_next = true;
      last = message.rows[i];
    }
  }
}

TEST_F(PageServer, ReportsTheControllerAndTheMissingTwin) {
  const auto peer = page();
  json twin;
  do twin = next_stream(*peer, "twin", false);
  while (twin.at("reason") == "");  // before the server has looked for the twin
  EXPECT_NE(twin.at("reason").get<std::string>().find("No such file"), std::string::npos) << twin;
  json state;
  do state = next_controller(*peer).at("axes")[0].at("state");
  while (state == "initialising" || state == "ready");
  EXPECT_EQ(state, "tracking");
}

TEST_F(PageServer, RefusesToWriteWithoutTheToken) {
  const auto peer = page();
  for (const json& request :
       {command("disable"), json{{"do", "stop"}}, json{{"do", "take_writer"}}, json{{"do", "save"}}})
    EXPECT_TRUE(says(peer->ask(request), "this request needs the token")) << request;
  EXPECT_TRUE(says(peer->ask({{"do", "token"}, {"token", token_text.substr(1)}}), "the token is wrong"));
  EXPECT_FALSE(bench_.asked_to_stop());
  EXPECT_TRUE(bench_.axis_is(0, controller::AxisState::tracking));
}

TEST_F(PageServer, GivesTheWriterRoleToOnePageAndNotifiesTheOther) {
  const auto one = writer();
  EXPECT_TRUE(one->is_ok(set_kp(0.1)));
  const auto other = page();
  EXPECT_TRUE(other->is_ok({{"do", "token"}, {"token", token_text}}));
  EXPECT_TRUE(says(other->ask(set_kp(0.2)), "take the role first"));
  EXPECT_TRUE(says(other->ask({{"do", "take_writer"}}), "another page has the writer's role"));
  EXPECT_TRUE(other->is_ok({{"do", "take_writer"}, {"force", true}}));
  EXPECT_EQ(one->next("writer").at("role"), "taken");
  EXPECT_TRUE(other->is_ok(set_kp(0.2)));
  EXPECT_TRUE(says(one->ask(set_kp(0.3)), "take the role first"));
}

TEST_F(PageServer, ChangesNothingWithoutTheWriterRole) {
  const auto peer = page();
  EXPECT_TRUE(peer->is_ok({{"do", "token"}, {"token", token_text}}));
  for (const char* what : {"save", "undo_save"})
    EXPECT_TRUE(says(peer->ask({{"do", what}}), "take the role first")) << what;
  for (const char* what : {"go_to", "resume", "set", "undo", "reload", "revert", "enable", "clear"})
    EXPECT_TRUE(says(peer->ask(command(what)), "take the role first")) << what;
}

TEST_F(PageServer, ReleasesTheControlSocketWithTheRole) {
  {
    const auto peer = writer();
    EXPECT_TRUE(peer->is_ok(set_kp(0.1)));
    Client script = bench_.client();
    EXPECT_TRUE(says(script.ask({{"do", "reload"}}), "has the right to write"));
  }
  EXPECT_TRUE(support::eventually([&] { return is_ok(bench_.client().ask({{"do", "reload"}})); }));
}

TEST_F(PageServer, AllowsAStopWithTheTokenAlone) {
  const auto one = writer();
  EXPECT_TRUE(one->is_ok(set_kp(0.1)));
  const auto other = page();
  EXPECT_TRUE(other->is_ok({{"do", "token"}, {"token", token_text}}));
  EXPECT_TRUE(other->is_ok({{"do", "stop"}}));
  EXPECT_TRUE(support::eventually([&] { return bench_.asked_to_stop(); }));
}

TEST_F(PageServer, UndoesOneSettingAndSavesTheOther) {
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.1)));
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  EXPECT_TRUE(peer->is_ok(command("undo")));
  const json shown = peer->ask({{"do", "save"}});
  EXPECT_NE(shown.at("diff").get<std::string>().find("\n+ kp                 = 0.1          # um per um\n"),
            std::string::npos)
      << shown;
  EXPECT_TRUE(says(peer->ask({{"do", "save"}, {"digest", "0"}}), "changed after"));
  EXPECT_TRUE(peer->is_ok({{"do", "save"}, {"digest", shown.at("digest")}}));
  EXPECT_NE(
      support::read_file(bench_.files() / "piezo.toml").find("kp                 = 0.1          # um per um"),
      std::string::npos);
}

TEST_F(PageServer, CapturesEachCycleAroundATrigger) {
  const auto peer = page_with_rows();
  json capture;
  WebPeer::Message rows;
  EXPECT_TRUE(support::eventually([&] {
    EXPECT_TRUE(peer->is_ok({{"do", "trigger"},
                             {"on", "level"},
                             {"axis", 0},
                             {"signal", "position_um"},
                             {"level", 15.0},
                             {"edge", "rising"},
                             {"pre_s", 0.02},
                             {"post_s", 0.03}}));
    capture = peer->next("capture");
    rows = peer->next_rows(3);
    EXPECT_EQ(rows.head[3], capture.at("number"));
    return capture.at("trigger_row") == 20 && rows.head[1] == 51u;
  })) << "a busy machine may lose rows of one capture, not of each; "
      << capture;
}

TEST_F(PageServer, DisconnectsAClientThatSendsTooMuch) {
  const auto long_message = page();
  long_message->send_frame(std::string(20'000, ' '));
  long_message->read_to_the_end();
  EXPECT_TRUE(page()->is_cut_off_by("{}"));
  const auto binary = page();
  binary->send_frame("bytes", 2);
  binary->read_to_the_end();
  EXPECT_EQ(page()->next("status").at("page").at("cut_off"), 3);
}

TEST_F(PageServer, RefusesAnInvalidRequestWithItsReason) {
  const auto peer = page();
  for (const char* text : {"[]", "{", "3"}) {
    peer->send_frame(text);
    EXPECT_TRUE(says(peer->next("answer"), "expected a JSON object")) << text;
  }
  EXPECT_TRUE(says(peer->ask({{"do", "dance"}}), "\"dance\" is not a request"));
  EXPECT_TRUE(says(peer->ask({{"do", "view"}, {"rate_Hz", 5000}}), "expected 10 to 1000"));
}

TEST_F(PageServer, DisconnectsAClientThatDoesNotRead) {
  const auto dead = page(), alive = page();
  json page_counters;
  do page_counters = alive->next("status").at("page");
  while (page_counters.at("clients") != 1);
  EXPECT_EQ(page_counters.at("cut_off"), 1);
}

/// Counts the connections of the control socket; the kernel lists accepted connections with its path.
std::size_t connections_to(const std::filesystem::path& socket) {
  constexpr const char* connected = " 03 ";
  std::ifstream list("/proc/net/unix");
  std::size_t count = 0;
  for (std::string line; std::getline(list, line);)
    if (line.ends_with(" " + socket.string()) && line.find(connected) != std::string::npos) ++count;
  return count;
}

TEST_F(PageServer, HasOneConnectionToTheControlSocket) {
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.1)));
  EXPECT_TRUE(peer->is_ok({{"do", "settings"}}));
  EXPECT_TRUE(peer->is_ok(command("disable")));
  next_controller(*peer);
  EXPECT_TRUE(support::eventually([&] { return connections_to(bench_.socket()) == 1; }));
}

TEST_F(PageServer, AnswersCommandsWhileAnotherPageDoesNotReadItsRows) {
  const auto peer = writer(), slow = page_with_rows();
  EXPECT_TRUE(slow->is_ok({{"do", "view"}, {"rate_Hz", 1000}}));
  for (int i = 1; i <= 20; ++i) EXPECT_TRUE(peer->is_ok(set_kp(0.01 * i)));
}

TEST_F(PageServer, AnswersARequestForSettingsDuringWhichTheRoleChanges) {
  const auto reader = page(), one = writer(), other = writer();
  for (int i = 0; i < 12; ++i) {  // one page may have no more waiting requests
    reader->send_frame(json{{"id", i}, {"do", "settings"}}.dump());
    EXPECT_TRUE((i % 2 == 0 ? one : other)->is_ok({{"do", "take_writer"}, {"force", true}}));
  }
  for (int answers = 0; answers < 12; ++answers) EXPECT_EQ(reader->next("answer").value("error", ""), "");
}

TEST_F(PageServer, FreesClosedConnections) {
  for (int i = 0; i < 2000; ++i) {
    const WebPeer silent(server_->port());
    if (i % 100 == 0) {
      EXPECT_EQ(status_of("GET /metrics HTTP/1.1"), 200);
    }
  }
  std::promise<std::size_t> kept;
  boost::asio::post(context_, [&] { kept.set_value(server_->sessions_kept()); });
  EXPECT_LE(kept.get_future().get(), 33U) << "32 that may be open, and the newest";
}

TEST_F(PageServer, DropsTheOldestUnauthorisedClientForANewOne) {
  std::vector<std::unique_ptr<WebPeer>> strangers;
  for (int i = 0; i < 32; ++i) {
    strangers.push_back(page());
    EXPECT_TRUE(strangers.back()->is_ok({{"do", "view"}, {"rate_Hz", 10}}));
    for (const auto& peer : strangers) peer->drain();
  }
  const auto operating = writer();
  EXPECT_TRUE(operating->is_ok({{"do", "stop"}}));
  strangers.front()->read_to_the_end();
  EXPECT_FALSE(strangers.back()->next("status").is_null());
}

TEST_F(PageServer, AcceptsAtMost32ClientsWithTheToken) {
  constexpr unsigned char pong = 10;
  std::vector<std::unique_ptr<WebPeer>> all;
  for (int i = 0; i < 32; ++i) {
    all.push_back(writer());
    EXPECT_TRUE(all.back()->is_ok({{"do", "view"}, {"rate_Hz", 10}}));
    for (const auto& peer : all) {  // the server disconnects a client that is silent or does not read
      peer->send_frame("", pong);
      peer->drain();
    }
  }
  EXPECT_EQ(WebPeer(server_->port()).upgrade(), 0) << "closed at once";
  all.pop_back();
  EXPECT_TRUE(support::eventually([&] { return WebPeer(server_->port()).upgrade() == 101; }));
}

TEST_F(PageServer, ExecutesAStopWithinAFlood) {
  const auto peer = writer();
  for (int i = 0; i < 48; ++i) peer->send_frame("{}");
  peer->send_frame(R"({"id": 1, "do": "stop"})");
  EXPECT_TRUE(support::eventually([&] { return bench_.asked_to_stop(); }));
}

TEST_F(PageServer, AllowsToDisableAnAxisWithTheTokenAlone) {
  const auto one = writer();
  EXPECT_TRUE(one->is_ok(set_kp(0.1)));
  const auto other = page();
  EXPECT_TRUE(says(other->ask(command("disable")), "this request needs the token"));
  EXPECT_TRUE(other->is_ok({{"do", "token"}, {"token", token_text}}));
  EXPECT_TRUE(other->is_ok(command("disable")));
  EXPECT_TRUE(bench_.axis_is(0, controller::AxisState::offline));
}

TEST_F(PageServer, ReportsTheStateDuringSlowRequestsOfOtherPages) {
  const auto watcher = page();
  std::atomic<bool> is_done = false;
  const auto ask_without_end = [&] {
    const auto peer = page();
    while (!is_done) {
      for (int id = 1; id <= 8; ++id)
        peer->send_frame(json{{"id", id}, {"do", "bode"}, {"axis", "x"}}.dump());
      for (int answers = 0; answers < 8; ++answers) peer->next("answer");
    }
  };
  std::thread one(ask_without_end), other(ask_without_end);
  for (int known = 0; known < 5;) known += watcher->next("status").at("controller").is_object() ? 1 : 0;
  is_done = true;
  one.join();
  other.join();
}

TEST_F(PageServer, AcceptsAViewOfTenToAThousandRowsPerSecond) {
  const auto peer = page();
  for (const double rate_Hz : {10.0, 1000.0})
    EXPECT_TRUE(peer->is_ok({{"do", "view"}, {"rate_Hz", rate_Hz}}));
  for (const double rate_Hz : {9.99, 1000.01})
    EXPECT_FALSE(peer->is_ok({{"do", "view"}, {"rate_Hz", rate_Hz}}));
}

TEST_F(PageServer, RefusesRequestsBeyondTheShareOfAPage) {
  const auto peer = page();
  EXPECT_TRUE(peer->is_ok({{"do", "view"}, {"rate_Hz", 10}}));
  std::string all;  // sent in one piece: no answer is ready before the server has the last request
  for (int id = 100; id < 140; ++id)
    all += WebPeer::frame(json{{"id", id}, {"do", "bode"}, {"axis", "x"}}.dump());
  EXPECT_TRUE(peer->send(all));
  int refused = 0, answered = 0;
  for (int answers = 0; answers < 40; ++answers)
    ++(peer->next("answer").value("ok", false) ? answered : refused);
  EXPECT_GE(answered, 16);
  EXPECT_GT(refused, 0);
}

// A stopped process, or a loop that receives no processor time.
TEST_F(PageServer, ReportsAnUnknownStateIfTheControllerIsSilent) {
  const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string silent = (bench_.files() / "silent.sock").string();
  silent.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(listen(listener, 8), 0);
  boost::asio::io_context context{1};
  PageService service(context,
                      {.config = bench_.files() / "piezo.toml",
                       .controller_socket = [&] { return silent; },
                       .twin_socket = [&] { return silent; }},
                      PageAccess({}, token_text));
  HttpServer server(context, "127.0.0.1", std::uint16_t{0}, service);
  std::thread thread([&] { context.run(); });
  WebPeer peer(server.port());
  EXPECT_EQ(peer.upgrade(), 101);
  EXPECT_TRUE(peer.next("status").at("controller").is_null());
  WebPeer metrics(server.port());
  EXPECT_EQ(metrics.request("GET /metrics HTTP/1.1"), 200);
  const std::string text = metrics.body();
  EXPECT_NE(text.find("hystcan_up 0\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("axis_fault"), std::string::npos) << text;
  context.stop();
  thread.join();
  close(listener);
}

TEST_F(PageServer, ReportsTheEndOfTheController) {
  const auto peer = page_with_rows();
  bench_.end_service();
  const json ended = next_stream(*peer, "controller", false);
  EXPECT_FALSE(ended.at("reason").get<std::string>().empty());
  json status;
  do status = peer->next("status");
  while (!status.at("controller").is_null());
  EXPECT_TRUE(says(peer->ask({{"do", "settings"}}), "check that the controller is running"));
}

}  // namespace
}  // namespace hystcan::app::page_server_test
