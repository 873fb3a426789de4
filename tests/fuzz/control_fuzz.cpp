// For any bytes as lines of the control socket, each line has at most one answer: `ok`, or an error with its
// reason. Nothing is thrown. The control thread never answers here.
//
// A `set` or `reload` reads the whole configuration again, which takes most of the time: an input contains
// only a few of them, and the configuration is small.
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <sstream>
#include <string>

#include "app/live/control_socket.h"
#include "app/live/controller_command_handler.h"
#include "tests/fuzz/demand.h"

using namespace hystcan;

namespace {

const std::filesystem::path file = HYSTCAN_SOURCE_DIR "/tests/fuzz/control.toml";
constexpr int most_reads = 4;

bool reads_the_configuration(const nlohmann::json& command) {
  const app::ControlCommand* row = app::find_command(command, app::Server::controller);
  return row != nullptr &&
         (row->reply_of(app::Server::controller) == app::Reply::changes || row->verb == app::Verb::settings);
}

void expect_an_answer(const nlohmann::json& answer) {
  fuzz::demand(answer.at("ok").is_boolean());
  fuzz::demand(answer.at("ok") == true || !answer.at("error").get<std::string>().empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const config::Config config = [] {
    config::Config shipped = config::load(file);
    shipped.record.folder = "/dev/null/runs";  // nothing is recorded
    return shipped;
  }();
  boost::asio::io_context context;
  controller::RequestLink requests;
  app::CycleOutlets outlets(config, {}, [](can::BusHealthLog::Level, const std::string&) {});
  app::LiveConfig live(file, config);
  app::ControllerCommandHandler handler(context, requests, outlets, live);

  int reads = 0;
  std::istringstream lines(std::string(reinterpret_cast<const char*>(data), size));
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json command = app::parse_command(line);
    if (!command.is_object()) continue;
    if (reads_the_configuration(command) && ++reads > most_reads) continue;
    const auto answers = std::make_shared<int>(0);
    handler.execute(command, {[answers](const nlohmann::json& answer) {
                      expect_an_answer(answer);
                      fuzz::demand(++*answers == 1);
                    }});
  }
  return 0;
}
