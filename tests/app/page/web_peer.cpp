#include "tests/app/page/web_peer.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <utility>

#include "tests/support/patience.h"

namespace hystcan::app {

WebPeer::WebPeer(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  support::limit_receive(socket_);
  EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
}

WebPeer::~WebPeer() { ::close(socket_); }

bool WebPeer::send(std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool WebPeer::is_cut_off_by(std::string_view payload) const {
  std::string many;
  for (int i = 0; i < 100; ++i) many += frame(payload);
  return support::eventually([&] { return !send(many); });
}

void WebPeer::drain() {
  std::array<char, 65536> chunk{};
  for (ssize_t received = 0; (received = ::recv(socket_, chunk.data(), chunk.size(), MSG_DONTWAIT)) > 0;)
    unread_.append(chunk.data(), static_cast<std::size_t>(received));
}

std::optional<std::string> WebPeer::take(std::size_t bytes) {
  std::array<char, 65536> chunk{};
  while (unread_.size() < bytes) {
    const ssize_t received = ::recv(socket_, chunk.data(), chunk.size(), 0);
    if (received <= 0) return std::nullopt;
    unread_.append(chunk.data(), static_cast<std::size_t>(received));
  }
  std::string taken = unread_.substr(0, bytes);
  unread_.erase(0, bytes);
  return taken;
}

std::optional<std::string> WebPeer::line() {
  std::string text;
  while (!text.ends_with("\r\n")) {
    const auto next = take(1);
    if (!next) return std::nullopt;
    text += *next;
  }
  return text.substr(0, text.size() - 2);
}

int WebPeer::request(const std::string& first_line, const std::string& further_lines) {
  send(first_line + "\r\n" + further_lines + "\r\n");
  const auto status = line();
  if (!status || status->size() < 12) return 0;
  for (auto header = line(); header && !header->empty(); header = line())
    if (header->starts_with("Content-Length: ")) body_size_ = std::stoul(header->substr(16));
  return std::stoi(status->substr(9, 3));
}

std::string WebPeer::body() { return take(std::exchange(body_size_, 0)).value_or(""); }

int WebPeer::upgrade(const std::string& further_lines) {
  return request("GET /socket HTTP/1.1",
                 further_lines +
                     "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                     "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
}

std::string WebPeer::frame(std::string_view payload, unsigned char opcode) {
  constexpr unsigned char final = 0x80, masked = 0x80;
  std::string frame{static_cast<char>(final | opcode)};
  if (payload.size() < 126) {
    frame += static_cast<char>(masked | payload.size());
  } else {
    frame += static_cast<char>(masked | 126U);
    frame += static_cast<char>(payload.size() >> 8U);
    frame += static_cast<char>(payload.size() & 0xFFU);
  }
  frame += std::string(4, '\0');  // a mask of zeros
  return frame += payload;
}

std::optional<WebPeer::Message> WebPeer::read() {
  const auto head = take(2);
  if (!head) return std::nullopt;
  const auto opcode = static_cast<unsigned char>((*head)[0]) & 0x0FU;
  std::uint64_t size = static_cast<unsigned char>((*head)[1]) & 0x7FU;
  if (size >= 126) {
    const auto bytes = take(size == 126 ? 2 : 8);
    if (!bytes) return std::nullopt;
    size = 0;
    for (const char byte : *bytes) size = size << 8U | static_cast<unsigned char>(byte);
  }
  const auto payload = take(size);
  if (!payload || opcode == 8) return std::nullopt;
  if (opcode == 9) {  // ping
    send_frame(*payload, 10);
    return read();
  }
  Message message;
  if (opcode == 1) {
    message.text = nlohmann::json::parse(*payload);
    return message;
  }
  message.head.resize(4);
  std::memcpy(message.head.data(), payload->data(), 16);
  message.rows.resize((size - 16) / sizeof(double));
  if (size > 16) std::memcpy(message.rows.data(), payload->data() + 16, size - 16);
  return message;
}

nlohmann::json WebPeer::next(const std::string& type) {
  while (auto message = read())
    if (message->text.is_object() && message->text.at("type") == type) return message->text;
  return {};
}

WebPeer::Message WebPeer::next_rows(std::uint32_t kind) {
  while (auto message = read())
    if (!message->head.empty() && message->head[0] == kind) return *message;
  return {};
}

nlohmann::json WebPeer::ask(nlohmann::json request) {
  request["id"] = ++last_id_;
  send_frame(request.dump());
  for (nlohmann::json answer = next("answer"); answer.is_object(); answer = next("answer"))
    if (answer.at("id") == last_id_) return answer;
  return nlohmann::json::object();
}

void WebPeer::read_to_the_end() {
  while (read()) continue;
}

}  // namespace hystcan::app
