#include "app/page/page_host.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <boost/asio/ip/address.hpp>
#include <boost/asio/signal_set.hpp>
#include <charconv>
#include <csignal>
#include <utility>

#include "app/page/assets.h"
#include "base/error.h"

namespace hystcan::app {
namespace {

void require_intended(const PageListening& listening, const std::string& source) {
  if (is_loopback(listening.address)) return;
  if (source == "demo")
    throw Error("--page " + listening.address,
                "other machines can reach this address; the page of a demo is for this machine only. "
                "Forward the port from the other machine instead (ssh -L 8080:localhost:8080 HOST). "
                "For a real controller, hystcan page has --listen and --expose");
  if (!listening.expose)
    throw Error(
        "--listen " + listening.address,
        "other machines can reach this address. "
        "The page is not encrypted: a listener on the network sees the token and can then move the stage. "
        "Forward the port instead (ssh -L 8080:localhost:8080 HOST), or add --expose");
  spdlog::warn(
      "the page is open to the network, unencrypted: a listener sees the token and can move the stage");
}

}  // namespace

PageListening PageListening::at(const std::string& text) {
  const auto colon = text.rfind(':');
  const auto fail = [&]() -> void {
    throw Error(fmt::format("\"{}\" is not a valid address", text),
                expect("for example 127.0.0.1:8080 or [::1]:8080"));
  };
  if (colon == std::string::npos) fail();
  PageListening result{.address = text.substr(0, colon), .port = 0};
  if (result.address.starts_with('[') && result.address.ends_with(']'))
    result.address = result.address.substr(1, result.address.size() - 2);
  if (result.address == "localhost") result.address = "127.0.0.1";
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, result.port);
  boost::system::error_code invalid;
  boost::asio::ip::make_address(result.address, invalid);
  if (error != std::errc() || rest != end || invalid) fail();
  return result;
}

PageHost::PageHost(PageOptions options, const PageListening& listening, const std::string& token)
    : address_(listening.address) {
  if (!page_is_built())
    throw RunError(
        "this program was built without its page, because npm was missing; build it with: "
        "scripts/packages test && cmake --preset release && cmake --build --preset release");
  require_intended(listening, options.source);
  options.exposed = !is_loopback(address_);
  const char* const option = options.source == "demo" ? "--page" : "--listen";
  service_ = std::make_unique<PageService>(context_, std::move(options), PageAccess(listening.names, token));
  try {
    server_ = std::make_unique<HttpServer>(context_, address_, listening.port, *service_);
  } catch (const RunError& error) {
    throw RunError({}, error, {.remedy = fmt::format("set another address with {}", option)});
  }
}

std::string PageHost::url() const {
  const bool is_every_address = boost::asio::ip::make_address(address_).is_unspecified();
  const bool is_v6 = address_.find(':') != std::string::npos;
  return fmt::format("http://{}:{}/",
                     is_every_address ? "localhost"
                     : is_v6          ? "[" + address_ + "]"
                                      : address_,
                     server_->port());
}

void PageHost::run() {
  boost::asio::signal_set signals(context_, SIGINT, SIGTERM);
  signals.async_wait([this](const boost::system::error_code& error, int) {
    if (!error) context_.stop();
  });
  while (!context_.stopped()) {
    try {
      context_.run();
    } catch (const std::exception& error) {  // an exception of one handler does not end the server
      spdlog::error("page: {}", error_text(error));
    }
  }
}

}  // namespace hystcan::app
