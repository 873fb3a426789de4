#include "app/page/stream_source.h"

#include <fmt/format.h>

#include <array>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <chrono>
#include <istream>
#include <utility>
#include <vector>

#include "app/live/command_handler.h"
#include "base/error.h"

namespace hystcan::app {
namespace {

using boost::asio::local::stream_protocol;
using boost::system::error_code;

constexpr auto pause_before_next = std::chrono::milliseconds(500);
constexpr auto longest_pause = std::chrono::seconds(3);  // a batch comes every 20 ms
constexpr std::size_t longest_greeting = 65'536;
constexpr std::size_t longest_batch = 16'777'216;

}  // namespace

StreamSource::StreamSource(boost::asio::io_context& context, std::function<std::filesystem::path()> place,
                           StreamHandler& handler)
    : place_(std::move(place)),
      handler_(handler),
      socket_(context),
      limit_(context),
      pause_(context),
      received_(longest_batch + longest_greeting) {
  connect();
}

void StreamSource::connect() {
  received_.consume(received_.size());
  ++attempt_;
  try {
    file_ = place_();
    socket_ = stream_protocol::socket(socket_.get_executor());
    await();
    socket_.async_connect(stream_protocol::endpoint(file_.string()),
                          [this, attempt = attempt_](const error_code& error) {
                            if (attempt != attempt_) return;
                            if (error) return fail(error.message());
                            read_greeting();
                          });
  } catch (const std::exception& error) {
    fail(error_text(error));
  }
}

void StreamSource::await() {
  limit_.expires_after(longest_pause);
  limit_.async_wait([this, attempt = attempt_](const error_code& cancelled) {
    if (!cancelled && attempt == attempt_) fail("sends nothing");
  });
}

void StreamSource::read_greeting() {
  boost::asio::async_read_until(
      socket_, received_, '\n', [this, attempt = attempt_](const error_code& error, std::size_t) {
        if (attempt != attempt_) return;
        if (error) return fail(error.message());
        std::istream stream(&received_);
        std::string line;
        std::getline(stream, line);
        if (line.size() > longest_greeting)
          return fail("is not a stream of hystcan: its greeting is too long");
        try {
          const nlohmann::json greeting = parse_command(line);
          columns_ = greeting.at("columns").size();
          if (columns_ == 0 || greeting.at("version") != 1) return fail("is a stream of another version");
          handler_.begun(greeting);
        } catch (const std::exception& invalid) {
          return fail(fmt::format("is not a stream of hystcan: {}", error_text(invalid)));
        }
        read_head();
      });
}

void StreamSource::read_head() {
  std::array<std::uint32_t, 2> head{};
  await();
  const std::size_t missing = sizeof head - std::min(sizeof head, received_.size());
  boost::asio::async_read(socket_, received_, boost::asio::transfer_exactly(missing),
                          [this, attempt = attempt_, head](const error_code& error, std::size_t) mutable {
                            if (attempt != attempt_) return;
                            if (error) return fail(error.message());
                            received_.sgetn(reinterpret_cast<char*>(head.data()), sizeof head);
                            read_rows(head[0], head[1]);
                          });
}

void StreamSource::read_rows(std::uint32_t rows, std::uint32_t lost) {
  const std::size_t bytes = std::size_t{rows} * columns_ * sizeof(double);
  if (bytes > longest_batch) return fail("sends a batch that is too long");
  const std::size_t missing = bytes - std::min(bytes, received_.size());
  boost::asio::async_read(socket_, received_, boost::asio::transfer_exactly(missing),
                          [this, attempt = attempt_, bytes, lost](const error_code& error, std::size_t) {
                            if (attempt != attempt_) return;
                            if (error) return fail(error.message());
                            std::vector<double> values(bytes / sizeof(double));
                            received_.sgetn(reinterpret_cast<char*>(values.data()),
                                            static_cast<std::streamsize>(bytes));
                            handler_.received(values, lost);
                            read_head();
                          });
}

void StreamSource::fail(const std::string& reason) {
  ++attempt_;
  limit_.cancel();
  error_code ignored;
  socket_.close(ignored);
  handler_.ended(fmt::format("{}: {}", file_.string(), reason));
  pause_.expires_after(pause_before_next);
  pause_.async_wait([this](const error_code& cancelled) {
    if (!cancelled) connect();
  });
}

}  // namespace hystcan::app
