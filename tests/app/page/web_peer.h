// A client of the page's server: HTTP and WebSocket over a plain socket, as described in
// docs/page_protocol.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::app {

class WebPeer {
 public:
  explicit WebPeer(std::uint16_t port);
  ~WebPeer();
  WebPeer(const WebPeer&) = delete;
  WebPeer& operator=(const WebPeer&) = delete;

  /// Returns false if the server has closed the connection.
  bool send(std::string_view bytes) const;
  /// Returns the status of the answer to these lines; 0 if the server closes the connection instead.
  int request(const std::string& first_line, const std::string& further_lines = "Host: localhost\r\n");
  std::string body();
  /// Returns the status of the upgrade: 101 after success.
  int upgrade(const std::string& further_lines = "Host: localhost\r\n");

  static std::string frame(std::string_view payload, unsigned char opcode = 1);
  bool send_frame(std::string_view payload, unsigned char opcode = 1) const {
    return send(frame(payload, opcode));
  }
  /// Sends the message repeatedly, a hundred times per step, until the server closes the connection; returns
  /// false if it does not.
  bool is_cut_off_by(std::string_view payload) const;
  struct Message {
    nlohmann::json text{};  ///< null for rows
    std::vector<std::uint32_t> head{};
    std::vector<double> rows{};
  };
  /// Returns an empty value if the server has closed the connection.
  std::optional<Message> read();
  /// Returns the next text message of this type; null if the connection ends before.
  nlohmann::json next(const std::string& type);
  /// Returns the next rows of this kind; empty if the connection ends before.
  Message next_rows(std::uint32_t kind);
  /// Sends a request and reads until its answer.
  nlohmann::json ask(nlohmann::json request);
  bool is_ok(const nlohmann::json& request) { return ask(request).value("ok", false); }
  /// Reads until the server has closed the connection.
  void read_to_the_end();
  /// Reads all data that has arrived, for a later read(): the server disconnects a client that does not read.
  void drain();

 private:
  std::optional<std::string> take(std::size_t bytes);
  std::optional<std::string> line();

  int socket_;
  std::string unread_;
  std::size_t body_size_ = 0;
  int last_id_ = 0;
};

}  // namespace hystcan::app
