#include "app/page/page_clients.h"

#include <algorithm>

namespace hystcan::app {
namespace {

constexpr int most_messages_per_s = 50;

}  // namespace

bool PageClient::sends_too_much() {
  const auto now = std::chrono::steady_clock::now();
  if (now - second >= std::chrono::seconds(1)) {
    second = now;
    messages = 0;
  }
  return ++messages > most_messages_per_s;
}

PageClient& PageClients::add(WebClient& web) {
  const std::uint64_t number = next_++;
  PageClient& client = clients_.emplace(number, PageClient{.web = web, .number = number}).first->second;
  counters.clients = clients_.size();
  return client;
}

void PageClients::remove(const PageClient& client) {
  clients_.erase(client.number);
  counters.clients = clients_.size();
}

PageClient* PageClients::of(const WebClient& web) {
  const auto found = std::ranges::find_if(clients_, [&](const auto& one) { return &one.second.web == &web; });
  return found == clients_.end() ? nullptr : &found->second;
}

PageClient* PageClients::with(std::uint64_t number) {
  const auto found = clients_.find(number);
  return found == clients_.end() ? nullptr : &found->second;
}

void PageClients::send_all(const nlohmann::json& message) {
  for (auto& [number, client] : clients_) client.send(message);
}

bool PageClients::make_room() {
  const auto oldest =
      std::ranges::find_if(clients_, [](const auto& one) { return !one.second.is_authorised; });
  if (oldest == clients_.end()) return false;
  oldest->second.web.cut_off();
  return true;
}

}  // namespace hystcan::app
