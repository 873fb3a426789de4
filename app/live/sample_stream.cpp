#include "app/live/sample_stream.h"

#include <algorithm>
#include <array>
#include <bit>
#include <boost/asio/write.hpp>
#include <chrono>
#include <utility>

#include "can/socketcan/cancel_timer.h"

namespace hystcan::app {
namespace {

using boost::asio::local::stream_protocol;
using boost::system::error_code;

constexpr auto batch_time = std::chrono::milliseconds(20);
constexpr auto longest_silence = std::chrono::seconds(2);
constexpr std::size_t most_listeners = 4;

static_assert(std::endian::native == std::endian::little, "numbers are sent as they are in memory");

using Batch = std::shared_ptr<const std::vector<double>>;

}  // namespace

/// One client connection. The object exists while one of its asynchronous operations is pending.
class SampleStream::Session : public std::enable_shared_from_this<Session> {
 public:
  Session(stream_protocol::socket socket, std::size_t columns)
      : socket_(std::move(socket)), columns_(columns), limit_(socket_.get_executor()) {}

  void greet(const std::string& greeting) {
    text_ = greeting + "\n";
    write(boost::asio::buffer(text_));
  }

  /// Starts to send a batch. If the previous batch is still being sent, the rows of the new batch are lost
  /// for this connection and counted.
  void send(const Batch& batch, std::uint32_t lost) {
    const auto rows = static_cast<std::uint32_t>(batch->size() / columns_);
    lost_ += lost;
    if (is_writing_) {
      lost_ += rows;
      return;
    }
    batch_ = batch;
    head_ = {rows, std::exchange(lost_, 0)};
    write(std::array<boost::asio::const_buffer, 2>{boost::asio::buffer(head_), boost::asio::buffer(*batch_)});
  }

  void close() {
    error_code ignored;
    socket_.close(ignored);
    can::cancel_timer(limit_);
  }

 private:
  template <class Buffers>
  void write(const Buffers& buffers) {
    is_writing_ = true;
    limit_.expires_after(longest_silence);
    limit_.async_wait([self = weak_from_this()](const error_code& cancelled) {
      if (const auto session = self.lock(); session && !cancelled) session->close();
    });
    boost::asio::async_write(socket_, buffers,
                             [self = shared_from_this()](const error_code& error, std::size_t) {
                               self->limit_.cancel();
                               self->is_writing_ = false;
                               if (error) return self->close();
                               self->keep();
                             });
  }
  /// Waits until the client closes the connection. Without this pending operation the session would end.
  void keep() {
    if (std::exchange(is_kept_, true)) return;
    socket_.async_wait(stream_protocol::socket::wait_error,
                       [self = shared_from_this()](const error_code&) { self->close(); });
  }

  stream_protocol::socket socket_;
  std::size_t columns_;
  boost::asio::steady_timer limit_;
  std::string text_;
  std::array<std::uint32_t, 2> head_{};
  Batch batch_;
  std::uint32_t lost_ = 0;
  bool is_writing_ = false;
  bool is_kept_ = false;
};

SampleStream::SampleStream(boost::asio::io_context& context, std::filesystem::path file, std::string greeting,
                           SampleBoard& board)
    : greeting_(std::move(greeting)),
      board_(board),
      timer_(context),
      listener_(context, std::move(file),
                [this](LocalListener::Socket connection) { admit(std::move(connection)); }) {}

SampleStream::~SampleStream() {
  board_.set_listening(false);
  for (const auto& session : sessions_)
    if (const auto open = session.lock()) open->close();
}

void SampleStream::admit(stream_protocol::socket connection) {
  std::erase_if(sessions_, [](const std::weak_ptr<Session>& session) { return session.expired(); });
  // If there are too many connections, `connection` is destroyed and thereby closed.
  if (sessions_.size() >= most_listeners) return;
  const auto session = std::make_shared<Session>(std::move(connection), board_.columns());
  sessions_.push_back(session);
  session->greet(greeting_);
  if (!board_.is_listening()) board_.take(values_);  // discards old rows, which an earlier listener left
  board_.set_listening(true);
  if (!std::exchange(armed_, true)) arm();
}

void SampleStream::arm() {
  timer_.expires_after(batch_time);
  timer_.async_wait([this, alive = std::weak_ptr(alive_)](const error_code&) {
    if (!alive.expired()) send();
  });
}

void SampleStream::send() {
  std::erase_if(sessions_, [](const std::weak_ptr<Session>& session) { return session.expired(); });
  if (sessions_.empty()) {
    board_.set_listening(false);
    armed_ = false;
    return;
  }
  const std::uint32_t lost = board_.take(values_);
  const Batch batch = std::make_shared<const std::vector<double>>(values_);
  for (const auto& session : sessions_)
    if (const auto open = session.lock()) open->send(batch, lost);
  arm();
}

std::filesystem::path stream_beside(const std::filesystem::path& control_socket) {
  std::filesystem::path stream = control_socket;
  return stream.replace_extension(".stream.sock");
}

}  // namespace hystcan::app
