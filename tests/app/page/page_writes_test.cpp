// The changes made by a page: settings, segments, the file, the rehearsal of a demo; and the events that
// report them.
#include <gtest/gtest.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "app/live/answer_json.h"
#include "app/page/page_events.h"
#include "app/page/writer_role.h"
#include "tests/app/page/page_bench.h"

namespace hystcan::app::page_writes_test {
namespace {

using nlohmann::json;

/// Returns the next event with this text; null if the connection ends before.
json event_with(WebPeer& peer, const std::string& words) {
  json event;
  do event = peer.next("event");
  while (!event.is_null() && event.at("text").get<std::string>().find(words) == std::string::npos);
  return event;
}

TEST_F(PageServer, ReportsEveryChangeToEveryPage) {
  const auto one = writer(), other = page();
  const json page_number = other->next("hello").at("page");
  EXPECT_TRUE(one->is_ok(set_kp(0.1)));
  const json event = event_with(*other, "kp");
  EXPECT_EQ(event.at("by"), "page " + std::to_string(page_number.get<int>() - 1));
  EXPECT_EQ(event.at("text"), "set axis[0].control.kp: 0 -> 0.1");
  EXPECT_EQ(event.at("key"), "axis[0].control.kp");
  EXPECT_EQ(event.at("from"), "0");
  EXPECT_EQ(event.at("to"), "0.1");
}

TEST_F(PageServer, ReportsARefusedCommandWithItsReason) {
  const auto peer = writer(), other = page();
  EXPECT_FALSE(peer->is_ok(set_kp(-1.0)));
  const json event = event_with(*other, "refused");
  EXPECT_EQ(event.at("level"), "warning");
  EXPECT_NE(event.at("text").get<std::string>().find("expected a number >= 0"), std::string::npos) << event;
}

TEST_F(PageServer, ReportsASettingChangedByAnotherProgram) {
  const auto peer = page();
  EXPECT_TRUE(peer->is_ok({{"do", "settings"}}));
  EXPECT_TRUE(is_ok(bench_.client().ask({{"do", "set"}, {"axis", "x"}, {"key", "kp"}, {"value", 0.3}})));
  EXPECT_TRUE(peer->is_ok({{"do", "settings"}}));
  const json event = event_with(*page(), "kp");
  EXPECT_EQ(event.at("by"), "file or control socket");
  EXPECT_EQ(event.at("to"), "0.3");
}

/// A machine that stalls for some seconds loses the stream, not the controller.
TEST_F(PageServer, ReportsASettingChangedWhileTheStreamWasLost) {
  boost::asio::io_context context;
  PageClients clients;
  PageEvents events(clients);
  const auto place = [this] { return bench_.socket(); };
  ControlLink link(context, place, support::patience), ending(context, place, support::patience);
  WriterRole role(link, ending, clients, events);
  const auto read = [&] {
    bool is_read = false;
    role.read_settings([&](const json& answer) { is_read = answer.value("ok", false); });
    context.restart();
    while (!is_read && context.run_one() > 0) {
    }
    EXPECT_TRUE(is_read);
  };
  read();
  EXPECT_TRUE(is_ok(bench_.client().ask({{"do", "set"}, {"axis", "x"}, {"key", "kp"}, {"value", 0.3}})));
  role.controller_changed();
  read();
  ASSERT_EQ(events.newest().size(), 1u);
  EXPECT_EQ(events.newest().front().at("text"), "set axis[0].control.kp: 0 -> 0.3");
}

TEST(CommandEvents, NameTheFirstOfManyChangesAndTheNumberOfTheOthers) {
  ChangesAnswer answer;
  for (int i = 0; i < 25; ++i) answer.changed.push_back({"k" + std::to_string(i), "", "1"});
  const auto events = command_events("page 1", {{"do", "reload"}}, answer_json(answer));
  ASSERT_EQ(events.size(), 21u);
  EXPECT_EQ(events.front().at("text"), "reload k0: (none) -> 1");
  EXPECT_EQ(events.back().at("text"), "reload: 5 more keys");
}

TEST_F(PageServer, KeepsTheFormerFileAndExchangesItWithTheSavedOne) {
  const auto file = bench_.files() / "piezo.toml", kept = bench_.files() / "piezo.toml.before-save";
  const std::string former = support::read_file(file);
  const auto peer = writer();
  EXPECT_FALSE(peer->ask({{"do", "settings"}}).at("undo_save").get<bool>());
  EXPECT_TRUE(says(peer->ask({{"do", "undo_save"}}), "no save to undo"));
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  const auto exchange = [&](const char* what) {
    const json shown = peer->ask({{"do", what}});
    EXPECT_EQ(shown.at("kept"), "piezo.toml.before-save");
    return peer->ask({{"do", what}, {"digest", shown.at("digest")}});
  };
  EXPECT_TRUE(is_ok(exchange("save")));
  const std::string saved = support::read_file(file);
  EXPECT_NE(saved, former);
  EXPECT_EQ(support::read_file(kept), former);
  EXPECT_TRUE(peer->ask({{"do", "settings"}}).at("undo_save").get<bool>());
  EXPECT_TRUE(says(peer->ask({{"do", "undo_save"}, {"digest", "0"}}), "changed after"));
  EXPECT_FALSE(exchange("undo_save").contains("not_applied"));
  EXPECT_EQ(support::read_file(file), former);
  EXPECT_EQ(support::read_file(kept), saved);
  EXPECT_TRUE(is_ok(exchange("undo_save")));
  EXPECT_EQ(support::read_file(file), saved);
}

TEST_F(PageServer, ReportsASaveAndItsUndoToALaterPage) {
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  for (const char* what : {"save", "undo_save"}) EXPECT_TRUE(is_ok(confirm(*peer, what)));
  const auto later = page();
  EXPECT_EQ(event_with(*later, "save").at("text"), "save piezo.toml");
  EXPECT_EQ(event_with(*later, "save").at("text"), "undo save of piezo.toml");
}

TEST_F(PageServer, UndoesASaveAfterTheFileWasDamaged) {
  const auto file = bench_.files() / "piezo.toml";
  const std::string former = support::read_file(file);
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  EXPECT_TRUE(is_ok(confirm(*peer, "save")));
  for (const char* broken : {"format = 1\n", "this is no TOML ["}) {
    std::ofstream(file) << broken;
    EXPECT_FALSE(is_ok(peer->ask({{"do", "settings"}})));
    std::ofstream(bench_.files() / "piezo.toml.before-save") << former;
    EXPECT_TRUE(is_ok(confirm(*peer, "undo_save")));
    EXPECT_EQ(support::read_file(file), former);
  }
}

TEST_F(PageServer, HasNoSettingToUndoAfterTheControllerHasReadTheSavedFile) {
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  const auto settings_to_undo = [&] { return peer->ask({{"do", "settings"}}).at("undo").get<int>(); };
  EXPECT_EQ(settings_to_undo(), 1);
  EXPECT_TRUE(is_ok(confirm(*peer, "save")));
  EXPECT_TRUE(support::eventually([&] { return settings_to_undo() == 0; }));
}

TEST_F(PageServer, SavesNothingIfTheFormerFileCannotBeKept) {
  const auto file = bench_.files() / "piezo.toml";
  const std::string former = support::read_file(file);
  std::filesystem::create_directory(bench_.files() / "piezo.toml.before-save");
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  EXPECT_TRUE(says(confirm(*peer, "save"), "cannot be kept"));
  EXPECT_EQ(support::read_file(file), former);
}

TEST_F(PageServer, GivesTheKeptFileTheModeOfTheFile) {
  const auto file = bench_.files() / "piezo.toml", kept = bench_.files() / "piezo.toml.before-save";
  using std::filesystem::perms;
  std::filesystem::permissions(file, perms::owner_read | perms::owner_write);
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  EXPECT_TRUE(is_ok(confirm(*peer, "save")));
  EXPECT_EQ(std::filesystem::status(kept).permissions(), perms::owner_read | perms::owner_write);
}

TEST_F(PageServer, SetsSegmentListsAndKeysOfSegments) {
  const auto peer = writer();
  const json sine{{"kind", "sine"},      {"low_um", 5.0}, {"high_um", 20.0},
                  {"frequency_Hz", 5.0}, {"cycles", 5.0}, {"transition_s", 0.2}};
  EXPECT_TRUE(peer->is_ok(set("setpoint", {sine, sine, sine})));
  EXPECT_TRUE(peer->is_ok(set("setpoint[2].high_um", 18.0)));
  EXPECT_TRUE(peer->is_ok({{"do", "curves"}, {"axis", "x"}}));
  EXPECT_TRUE(peer->is_ok(set("setpoint", json::array({sine}))));
  EXPECT_TRUE(peer->is_ok({{"do", "command"}, {"command", {{"do", "undo"}}}}));
  json high;
  const json answer = peer->ask({{"do", "settings"}});
  for (const json& setting : answer.at("settings"))
    if (setting.at("key") == "axis[0].control.setpoint[2].high_um") high = setting.at("value");
  EXPECT_EQ(high, "18");
}

TEST_F(PageServer, RefusesToStartARealController) {
  EXPECT_TRUE(says(writer()->ask({{"do", "start"}}), "hystcan controller piezo.toml"));
}

class PageOfADemo : public PageServer {
 protected:
  PageOfADemo()
      : PageServer([this] {
          ++starts_;
          if (is_broken_) throw std::runtime_error("kp is \"much\"");
        }) {}

  std::atomic<int> starts_ = 0;
  std::atomic<bool> is_broken_ = false;
};

TEST_F(PageOfADemo, StartsAgainOnlyWithTheToken) {
  EXPECT_TRUE(says(page()->ask({{"do", "start"}}), "this request needs the token"));
  EXPECT_EQ(starts_, 0);
  const auto other = page();
  EXPECT_TRUE(writer()->is_ok({{"do", "start"}}));
  EXPECT_EQ(starts_, 1);
  EXPECT_EQ(event_with(*other, "start again").at("level"), "info");
}

TEST_F(PageOfADemo, ReportsWhyItDoesNotStart) {
  is_broken_ = true;
  EXPECT_TRUE(says(writer()->ask({{"do", "start"}}), "kp is \"much\""));
}

/// Stores the lines of the log.
class CapturedLog {
 protected:
  CapturedLog() { spdlog::set_default_logger(std::make_shared<spdlog::logger>("", lines_)); }
  ~CapturedLog() { spdlog::set_default_logger(before_); }
  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;

  std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
  std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> lines_ =
      std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(1000);
};

class PageWithALog : protected CapturedLog, public PageServer {
 protected:
  PageWithALog() : PageServer([] {}) {}
};

TEST_F(PageWithALog, LogsEachCommandWithItsPage) {
  const auto peer = writer();
  EXPECT_TRUE(peer->is_ok(set_kp(0.2)));
  EXPECT_FALSE(peer->is_ok(set("\u202e", 1.0)));
  EXPECT_TRUE(is_ok(confirm(*peer, "save")));
  EXPECT_TRUE(peer->is_ok({{"do", "start"}}));
  EXPECT_TRUE(peer->is_ok({{"do", "stop"}}));
  std::string log;
  for (const std::string& line : lines_->last_formatted()) log += line;
  for (const char* words : {R"(page 1: {"axis":"x","do":"set","key":"kp","value":0.2})", R"("key":"\u202e")",
                            "page 1: save piezo.toml", "page 1: start again", "[warning] page 1: stop"})
    EXPECT_NE(log.find(words), std::string::npos) << words << " is not in\n" << log;
}

}  // namespace
}  // namespace hystcan::app::page_writes_test
