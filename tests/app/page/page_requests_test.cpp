// The requests of a page and their answers, and the order of waiting requests.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/page/page_bench.h"

namespace hystcan::app::page_requests_test {
namespace {

using nlohmann::json;

/// The element of a list with this `key`.
json with_key(const json& list, const std::string& key) {
  for (const json& one : list)
    if (one.at("key") == key) return one;
  return {};
}

TEST_F(PageServer, DescribesEachChangeableKey) {
  const json keys = page()->ask({{"do", "settings"}}).at("keys");
  EXPECT_EQ(with_key(keys, "axis[0].control.kp"), (json{{"key", "axis[0].control.kp"},
                                                        {"meaning", "proportional gain"},
                                                        {"unit", "um/um"},
                                                        {"range", "a number >= 0"}}));
  EXPECT_EQ(with_key(keys, "axis[1].control.drive_min_V"), (json{{"key", "axis[1].control.drive_min_V"},
                                                                 {"meaning", "lowest drive in a command"},
                                                                 {"unit", "V"}}));
  EXPECT_EQ(with_key(keys, "axis[0].control.start_up").at("choices"), (json{"wipe", "assume", "restore"}));
}

TEST_F(PageServer, ReportsSettingsWithUnitsButWithoutTheFilePath) {
  const json answer = page()->ask({{"do", "settings"}});
  EXPECT_EQ(with_key(answer.at("settings"), "axis[0].control.kp").at("unit"), "um/um");
  EXPECT_FALSE(answer.contains("file")) << answer;
}

TEST_F(PageServer, ShowsTheLoopAndTheModelWithTheSettingsInForce) {
  const auto peer = writer();
  const json bode{{"do", "bode"}, {"axis", "x"}};
  const json curves{{"do", "curves"}, {"axis", "x"}};
  const json loop_before = peer->ask(bode), curves_before = peer->ask(curves);
  EXPECT_TRUE(peer->is_ok(set("ki_per_s", 10.0)));
  EXPECT_TRUE(peer->is_ok(set("delays.sensor_delay_us", 500.0)));
  EXPECT_NE(peer->ask(bode).at("loop_dB"), loop_before.at("loop_dB"));
  EXPECT_GT(peer->ask(curves).at("delay_s"), curves_before.at("delay_s"));
}

TEST_F(PageServer, CountsRefusalsWithoutTheToken) {
  const auto peer = page();
  EXPECT_EQ(peer->next("status").at("page").at("refused"), 0);
  EXPECT_FALSE(peer->is_ok({{"do", "save"}}));
  EXPECT_FALSE(peer->is_ok({{"do", "token"}, {"token", "guess"}}));
  EXPECT_EQ(peer->next("status").at("page").at("refused"), 2);
}

TEST_F(PageServer, DelaysTheAnswerToAWrongTokenByASecond) {
  const auto peer = page();
  const auto began = std::chrono::steady_clock::now();
  peer->send(WebPeer::frame(R"({"id": 1, "do": "token", "token": "guess"})") +
             WebPeer::frame(json{{"id", 2}, {"do", "token"}, {"token", token_text}}.dump()));
  const json second = peer->next("answer");
  EXPECT_EQ(second.at("id"), 2);
  EXPECT_TRUE(says(second, "still being checked"));
  // Five per second: the server's timers expire in order, even if its thread is late.
  int states = 0;
  json message;
  do {
    message = peer->read().value_or(WebPeer::Message{}).text;  // null for rows
    states += message.is_object() && message.at("type") == "status" ? 1 : 0;
  } while (message.is_null() || message.at("type") != "answer");
  EXPECT_EQ(message.at("id"), 1);
  EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::seconds(1));
  EXPECT_LE(states, 7);
  EXPECT_TRUE(peer->is_ok({{"do", "token"}, {"token", token_text}}));
}

TEST_F(PageServer, AnswersATokenWithTheStateOfTheRole) {
  const auto peer = page();
  EXPECT_FALSE(peer->next("writer").at("authorised"));
  peer->send_frame(json{{"id", 1}, {"do", "token"}, {"token", token_text}}.dump());
  EXPECT_EQ(peer->next("writer"), (json{{"type", "writer"}, {"role", "free"}, {"authorised", true}}));
}

TEST_F(PageServer, AllowsOnlyTheHolderToReleaseTheRole) {
  const auto one = writer(), other = page();
  EXPECT_TRUE(other->is_ok({{"do", "token"}, {"token", token_text}}));
  EXPECT_TRUE(other->is_ok({{"do", "release_writer"}}));
  EXPECT_TRUE(one->is_ok(set_kp(0.1)));
  EXPECT_TRUE(one->is_ok({{"do", "release_writer"}}));
  EXPECT_TRUE(says(one->ask(set_kp(0.1)), "take the role first"));
  EXPECT_TRUE(other->is_ok({{"do", "take_writer"}}));
}

TEST_F(PageServer, TransfersTheRoleOnlyIfForceIsTrue) {
  const auto one = writer(), other = page();
  EXPECT_TRUE(one->is_ok({{"do", "take_writer"}})) << "its own";
  EXPECT_TRUE(other->is_ok({{"do", "token"}, {"token", token_text}}));
  for (const json& force : {json(false), json("true"), json(1)})
    EXPECT_FALSE(other->is_ok({{"do", "take_writer"}, {"force", force}})) << force;
}

TEST_F(PageServer, ForwardsOnlyTheCommandsOfAPage) {
  const auto peer = writer();
  EXPECT_TRUE(says(peer->ask({{"do", "command"}}), "expected a command of the control socket"));
  EXPECT_TRUE(says(peer->ask({{"do", "command"}, {"command", "set"}}), "expected a command"));
  EXPECT_TRUE(
      says(peer->ask(command("stop")), "\"stop\" is not a command of the page, expected go_to, resume"));
  const json refused = peer->ask(set_kp(-1.0));
  EXPECT_TRUE(says(refused, "expected a number >= 0"));
  EXPECT_EQ(refused.at("answer").at("error"), refused.at("error"));
  EXPECT_TRUE(peer->ask(set_kp(0.1)).at("answer").at("ok"));
}

TEST_F(PageServer, SendsNoCaptureAfterUntrigger) {
  const auto peer = page_with_rows(), other = page();
  const json trigger{{"do", "trigger"}, {"on", "level"},    {"axis", 0},    {"signal", "position_um"},
                     {"level", 15.0},   {"edge", "rising"}, {"pre_s", 0.0}, {"post_s", 0.01}};
  EXPECT_TRUE(peer->is_ok(trigger));
  EXPECT_TRUE(peer->is_ok({{"do", "untrigger"}}));
  EXPECT_TRUE(other->is_ok(trigger));
  EXPECT_FALSE(other->next("capture").is_null());
  peer->send_frame(R"({"id": 0, "do": "untrigger"})");
  for (json message; message.is_null() || message.at("type") != "answer" || message.at("id") != 0;) {
    message = peer->read().value().text;  // null for rows
    EXPECT_FALSE(message.is_object() && message.at("type") == "capture");
  }
}

TEST_F(PageServer, RefusesARequestWithoutAnId) {
  const auto peer = page();
  for (const char* text : {R"({"do": "untrigger"})", R"({"id": "1", "do": "untrigger"})"}) {
    peer->send_frame(text);
    const json answer = peer->next("answer");
    EXPECT_TRUE(says(answer, "\"id\" is missing")) << text;
    EXPECT_TRUE(answer.at("id").is_null()) << text;
  }
}

TEST_F(PageServer, CapturesNothingWithoutAController) {
  const auto peer = page_with_rows();
  bench_.end_service();
  EXPECT_FALSE(next_stream(*peer, "controller", false).is_null());
  EXPECT_TRUE(says(peer->ask({{"do", "trigger"}, {"on", "now"}, {"axis", 0}}), "no cycles to capture"));
}

TEST_F(PageServer, DisconnectsAFloodWithAnUnauthorisedStop) {
  const auto peer = page();
  EXPECT_TRUE(peer->is_cut_off_by(R"({"id": 1, "do": "stop"})"));
  EXPECT_FALSE(bench_.asked_to_stop());
}

TEST_F(PageServer, ReportsWhyARestoredFileIsNotApplied) {
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  EXPECT_TRUE(is_ok(confirm(*peer, "save")));
  bench_.files().edit("piezo.toml.before-save", "\"vcan0\"", "\"vcan1\"");
  const json undone = confirm(*peer, "undo_save");
  EXPECT_TRUE(is_ok(undone));
  EXPECT_NE(undone.value("not_applied", "").find("bus.interface"), std::string::npos) << undone;
}

class PageOfAnotherFile : public PageServer {
 protected:
  PageOfAnotherFile() : PageServer({}, "galfenol.toml") {}
};

TEST_F(PageOfAnotherFile, NeitherSavesNorShowsTheLoop) {
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  for (const json& request : {json{{"do", "save"}}, json{{"do", "undo_save"}},
                              json{{"do", "bode"}, {"axis", "x"}}, json{{"do", "curves"}, {"axis", "x"}}})
    EXPECT_TRUE(says(peer->ask(request), "start the page with the same file")) << request;
}

class Requests : public testing::Test {
 protected:
  /// Work that records its name and is done when finish() is called.
  RequestQueue::Work work(const std::string& name) {
    return [this, name](const RequestQueue::Done& done) {
      began_ += name;
      done_ = done;
    };
  }
  void finish() {
    std::exchange(done_, nullptr)();
    context_.restart();
    context_.run();
  }

  boost::asio::io_context context_;
  RequestQueue queue_{context_};
  std::string began_;
  RequestQueue::Done done_;
};

TEST_F(Requests, AreServedOneAtATimeInTurnsOfClients) {
  for (const auto& [client, name] : std::vector<std::pair<std::uint64_t, std::string>>{
           {2, "a"}, {2, "b"}, {2, "c"}, {3, "d"}, {1, "e"}, {3, "f"}})
    EXPECT_TRUE(queue_.add(client, work(name)));
  EXPECT_EQ(began_, "a") << "one";
  for (int i = 0; i < 6; ++i) finish();
  EXPECT_EQ(began_, "adebfc");
  EXPECT_TRUE(queue_.add(1, work("g")));
  EXPECT_EQ(began_, "adebfcg") << "at once, where nothing waits";
}

TEST_F(Requests, AreLimitedToSixteenForEachClient) {
  EXPECT_TRUE(queue_.add(1, work("-")));
  for (int i = 0; i < 16; ++i) EXPECT_TRUE(queue_.add(1, work("x")));
  EXPECT_FALSE(queue_.add(1, work("y")));
  EXPECT_TRUE(queue_.add(2, work("z")));
  for (int i = 0; i < 18; ++i) finish();
  EXPECT_EQ(began_, "-z" + std::string(16, 'x'));
}

TEST_F(Requests, AreDroppedIfTheirClientHasLeft) {
  EXPECT_TRUE(queue_.add(1, work("a")));
  EXPECT_TRUE(queue_.add(1, work("b")));
  EXPECT_TRUE(queue_.add(2, work("c")));
  queue_.leave(1);
  finish();
  finish();
  EXPECT_EQ(began_, "ac");
}

TEST_F(Requests, UseAtMostHalfTheTimeOfTheThread) {
  const auto took = std::chrono::milliseconds(30);
  std::chrono::steady_clock::time_point ended;
  EXPECT_TRUE(queue_.add(1, [&](const RequestQueue::Done& done) {
    const auto began = std::chrono::steady_clock::now();
    while ((ended = std::chrono::steady_clock::now()) < began + took) continue;
    done();
  }));
  EXPECT_TRUE(queue_.add(1, work("next")));
  EXPECT_EQ(began_, "");
  context_.run();
  EXPECT_EQ(began_, "next");
  EXPECT_GE(std::chrono::steady_clock::now(), ended + took);
}

}  // namespace
}  // namespace hystcan::app::page_requests_test
