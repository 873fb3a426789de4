// The page's server for tests, with a running controller in virtual time.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>

#include "app/page/page_service.h"
#include "tests/app/live/control_bench.h"
#include "tests/app/page/web_peer.h"

namespace hystcan::app {

inline const std::string token_text = "00112233445566778899aabbccddeeff";

class PageServer : public testing::Test {
 protected:
  /// `start_again`: for a demo. `config`: the page's file; the controller runs with piezo.toml.
  explicit PageServer(std::function<void()> start_again = {}, const char* config = "piezo.toml") {
    PageOptions options{.config = bench_.files() / config,
                        .start_command = "hystcan controller piezo.toml",
                        .controller_socket = [this] { return bench_.socket(); },
                        .twin_socket = [this] { return bench_.files() / "no.sock"; },
                        .answer_limit = support::patience,
                        .start_again = std::move(start_again)};
    service_ = std::make_unique<PageService>(context_, options, PageAccess({}, token_text));
    server_ = std::make_unique<HttpServer>(context_, "127.0.0.1", std::uint16_t{0}, *service_);
    thread_ = std::thread([this] { context_.run(); });
    EXPECT_TRUE(bench_.axis_is(0, controller::AxisState::tracking));
  }
  ~PageServer() override {
    context_.stop();
    thread_.join();
  }

  std::unique_ptr<WebPeer> page() {
    auto peer = std::make_unique<WebPeer>(server_->port());
    EXPECT_EQ(peer->upgrade(), 101);
    return peer;
  }
  /// A page whose server has the controller's stream: the server connects to it after the controller's start.
  std::unique_ptr<WebPeer> page_with_rows() {
    auto peer = page();
    EXPECT_FALSE(next_stream(*peer, "controller", true).is_null());
    return peer;
  }
  /// Returns the next message about a stream that exists, or does not exist; null if the connection ends
  /// before.
  static nlohmann::json next_stream(WebPeer& peer, const char* name, bool is_there) {
    nlohmann::json stream;
    do stream = peer.next("stream");
    while (!stream.is_null() && (stream.at("name") != name || stream.at("greeting").is_null() == is_there));
    return stream;
  }
  std::unique_ptr<WebPeer> writer() {
    auto peer = page();
    EXPECT_TRUE(peer->is_ok({{"do", "token"}, {"token", token_text}}));
    EXPECT_TRUE(peer->is_ok({{"do", "take_writer"}, {"force", true}}));
    return peer;
  }
  int status_of(const std::string& first_line, const std::string& lines = "Host: localhost\r\n") {
    return WebPeer(server_->port()).request(first_line, lines);
  }
  /// Returns the answer to `save` or `undo_save` with the digest of the shown text.
  static nlohmann::json confirm(WebPeer& peer, const char* what) {
    return peer.ask({{"do", what}, {"digest", peer.ask({{"do", what}}).at("digest")}});
  }
  static nlohmann::json command(const char* what) {
    return {{"do", "command"}, {"command", {{"do", what}, {"axis", "x"}}}};
  }
  static nlohmann::json set(const char* key, const nlohmann::json& value) {
    return {{"do", "command"}, {"command", {{"do", "set"}, {"axis", "x"}, {"key", key}, {"value", value}}}};
  }
  static nlohmann::json set_kp(double kp) { return set("kp", kp); }

  ControlBench bench_;
  boost::asio::io_context context_{1};
  std::unique_ptr<PageService> service_;
  std::unique_ptr<HttpServer> server_;
  std::thread thread_;
};

}  // namespace hystcan::app
