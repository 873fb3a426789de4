// For any bytes as messages of a client of the page, each message has at most one immediate answer: `ok`, or
// an error with its reason. Nothing is thrown, and without the token no request is sent to the control
// socket. There is no controller here.
#include <spdlog/spdlog.h>

#include <boost/asio/io_context.hpp>
#include <sstream>
#include <string>

#include "app/live/control_protocol.h"
#include "app/page/page_service.h"
#include "base/error.h"
#include "tests/app/page/two_axes.h"
#include "tests/fuzz/demand.h"

using namespace hystcan;

namespace {

const app::StreamGreeting greeting = app::two_axes();

class CountingClient final : public app::WebClient {
 public:
  void send_text(std::string text) override {
    const nlohmann::json message = nlohmann::json::parse(text);
    if (message.at("type") != "answer") return;
    ++answers;
    fuzz::demand(message.at("ok").is_boolean());
    fuzz::demand(message.at("ok") == true || !message.at("error").get<std::string>().empty());
  }
  bool takes_rows() const override { return true; }
  bool send_rows(const app::RowHead&, const app::RowBlock&) override { return true; }
  void cut_off() override { is_cut_off = true; }

  int answers = 0;
  bool is_cut_off = false;
};

void read_as_a_trigger(const std::string& line) {
  const nlohmann::json request = app::parse_command(line);
  if (!request.is_object()) return;
  try {
    app::Trigger trigger(request, greeting);
    fuzz::demand(trigger.axis() < 2);
    app::RowHistory history(greeting.columns.size(), 100);
    for (double value : {0.0, 1.0, -1.0, 20.0}) {  // the sanitizers detect a missing column
      const std::vector<double> row(history.columns(), value);
      history.put(row);
      trigger.put(row, history);
    }
  } catch (const Error&) {  // refused with its reason
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spdlog::set_level(spdlog::level::off);
  boost::asio::io_context context;
  const auto nowhere = [] { return std::filesystem::path("/nonexistent/control.sock"); };
  app::PageService service(context,
                           {.config = "none.toml", .controller_socket = nowhere, .twin_socket = nowhere},
                           app::PageAccess({}, "00112233445566778899aabbccddeeff"));
  CountingClient client;
  service.opened(client);
  std::istringstream lines(std::string(reinterpret_cast<const char*>(data), size));
  for (std::string line; !client.is_cut_off && std::getline(lines, line);) {
    read_as_a_trigger(line);
    client.answers = 0;
    service.received(client, line);
    fuzz::demand(client.answers <= 1);
  }
  service.closed(client);
  return 0;
}
