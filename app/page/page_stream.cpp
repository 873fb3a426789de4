#include "app/page/page_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <chrono>
#include <istream>
#include <stdexcept>
#include <utility>

#include "app/live/answer_json.h"
#include "app/live/control_protocol.h"
#include "app/live/sample_stream.h"
#include "base/error.h"

namespace hystcan::app {
namespace {

using boost::asio::local::stream_protocol;
using boost::system::error_code;

constexpr auto pause_before_next = std::chrono::milliseconds(500);
// Longest time without a batch; normally a batch arrives every 20 ms.
constexpr auto longest_pause = std::chrono::seconds(3);
constexpr std::size_t longest_greeting = 65'536;
constexpr std::size_t longest_batch = 16'777'216;
constexpr double history_s = 60.0;
constexpr double shortest_history_s = 12.0;  // in s; a capture of 10 s must fit into the history
constexpr double most_history_rows = 200'000.0;
constexpr double rows_of_the_past = 4'000.0;
constexpr std::size_t rows_of_a_block = 100;
constexpr double fastest_Hz = 1e5;
constexpr std::size_t most_axes = 64;

}  // namespace

PageStream::PageStream(boost::asio::io_context& context, std::string name, std::uint32_t kind,
                       std::function<std::filesystem::path()> control_socket, Hooks hooks)
    : name_(std::move(name)),
      kind_(kind),
      control_socket_(std::move(control_socket)),
      hooks_(std::move(hooks)),
      socket_(context),
      limit_(context),
      pause_(context),
      received_(longest_batch + longest_greeting) {
  // Connects later, because the object that owns the hooks is not complete yet.
  boost::asio::post(context, [this] { connect(); });
}

void PageStream::connect() {
  received_.consume(received_.size());
  ++attempt_;
  try {
    file_ = stream_beside(control_socket_());
    socket_ = stream_protocol::socket(socket_.get_executor());
    await();
    socket_.async_connect(stream_protocol::endpoint(file_.string()), then([this] { read_greeting(); }));
  } catch (const std::exception& error) {
    fail(error_text(error));
  }
}

void PageStream::await() {
  limit_.expires_after(longest_pause);
  limit_.async_wait([this, attempt = attempt_](const error_code& cancelled) {
    if (!cancelled && attempt == attempt_) fail("sends nothing");
  });
}

void PageStream::read_greeting() {
  boost::asio::async_read_until(
      socket_, received_, '\n', then([this] {
        std::istream stream(&received_);
        std::string line;
        std::getline(stream, line);
        if (line.size() > longest_greeting)
          return fail("is not a stream of hystcan: the greeting is too long");
        try {
          const auto greeting = read_object<StreamGreeting>(parse_command(line));
          if (greeting.columns.empty() || greeting.version != StreamGreeting().version)
            return fail("is a stream of another version of hystcan");
          begin(greeting);
        } catch (const std::exception& invalid) {
          return fail(fmt::format("is not a stream of hystcan: {}", error_text(invalid)));
        }
        read_head();
      }));
}

void PageStream::read_head() {
  constexpr std::size_t bytes = 2 * sizeof(std::uint32_t);
  await();
  const std::size_t missing = bytes - std::min(bytes, received_.size());
  boost::asio::async_read(socket_, received_, boost::asio::transfer_exactly(missing), then([this] {
                            std::array<std::uint32_t, 2> head{};
                            received_.sgetn(reinterpret_cast<char*>(head.data()), sizeof head);
                            read_rows(head[0], head[1]);
                          }));
}

void PageStream::read_rows(std::uint32_t rows, std::uint32_t lost) {
  const std::size_t bytes = std::size_t{rows} * history_->columns() * sizeof(double);
  if (bytes > longest_batch)
    return fail("sent more rows at once than the page accepts; the page connects again");
  const std::size_t missing = bytes - std::min(bytes, received_.size());
  boost::asio::async_read(
      socket_, received_, boost::asio::transfer_exactly(missing), then([this, bytes, lost] {
        std::vector<double> values(bytes / sizeof(double));
        received_.sgetn(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(bytes));
        take(values, lost);
        read_head();
      }));
}

void PageStream::fail(const std::string& reason) {
  ++attempt_;
  limit_.cancel();
  error_code ignored;
  socket_.close(ignored);
  end(fmt::format("{}: {}", file_.string(), reason));
  pause_.expires_after(pause_before_next);
  pause_.async_wait([this](const error_code& cancelled) {
    if (!cancelled) connect();
  });
}

void PageStream::begin(const StreamGreeting& greeting) {
  const auto axis = column_in(greeting, "axis");
  if (!axis) throw std::runtime_error("the stream has no column \"axis\"");
  const double rate = greeting.rate_Hz;
  const std::size_t axes = greeting.axes.size();
  if (greeting.stream != name_)
    throw std::runtime_error(fmt::format("another program sends this stream, expected the {}", name_));
  if (axes == 0 || axes > most_axes || !(rate > 0.0 && rate <= fastest_Hz))
    throw std::runtime_error("the axes or the rate of the stream are not valid");
  axis_ = *axis;
  const double rows_per_s = rate * static_cast<double>(axes);
  const double rows =
      std::clamp(history_s * rows_per_s, 1.0, std::max(most_history_rows, shortest_history_s * rows_per_s));
  history_.emplace(greeting.columns.size(), static_cast<std::size_t>(rows));
  greeting_ = greeting;
  lanes_.clear();
  hooks_.changed();
}

void PageStream::take(std::span<const double> values, std::uint32_t lost) {
  ++batch_;
  batch_begin_ = history_->end();
  const auto axes = static_cast<double>(greeting_.axes.size());
  const std::size_t columns = history_->columns();
  for (; values.size() >= columns; values = values.subspan(columns)) {
    const std::span<const double> row = values.first(columns);
    if (!(row[axis_] >= 0.0 && row[axis_] < axes)) continue;
    history_->put(row);
    hooks_.row(row);
  }
  hooks_.batch(lost);
  std::erase_if(lanes_, [&](const auto& lane) { return lane.second.batch != batch_; });
}

void PageStream::end(const std::string& reason) {
  const bool was_there = history_.has_value();
  history_.reset();
  lanes_.clear();
  if (std::exchange(reason_, reason) != reason || was_there) hooks_.changed();
}

nlohmann::json PageStream::message() const {
  const nlohmann::json greeting = is_there() ? as_json(greeting_) : nlohmann::json();
  nlohmann::json message{{"type", "stream"}, {"name", name_}, {"greeting", greeting}};
  if (!is_there()) message["reason"] = reason_;
  return message;
}

RowBlock PageStream::rows_at(double rate) {
  auto lane = lanes_.find(rate);
  if (lane == lanes_.end())
    lane =
        lanes_.emplace(rate, Lane{RowDecimator(greeting_, RowDecimator::bucket_for(greeting_.rate_Hz, rate))})
            .first;
  auto& [decimator, batch, rows] = lane->second;
  if (std::exchange(batch, batch_) == batch_) return rows;
  for (std::uint64_t i = std::max(batch_begin_, history_->first()); i < history_->end(); ++i)
    decimator.put(history_->row(i));
  std::vector<double> values = decimator.take();
  rows = values.empty() ? nullptr : std::make_shared<const std::vector<double>>(std::move(values));
  return rows;
}

std::vector<RowBlock> PageStream::past() const {
  const auto rows = static_cast<double>(history_->end() - history_->first());
  RowDecimator decimator(greeting_, RowDecimator::bucket_for(rows, rows_of_the_past));
  for (std::uint64_t i = history_->first(); i < history_->end(); ++i) decimator.put(history_->row(i));
  const std::vector<double> values = decimator.take();
  std::vector<RowBlock> blocks;
  const std::size_t most = rows_of_a_block * history_->columns();
  for (auto rest = std::span(values); !rest.empty(); rest = rest.subspan(std::min(rest.size(), most))) {
    const auto block = rest.first(std::min(rest.size(), most));
    blocks.push_back(std::make_shared<const std::vector<double>>(block.begin(), block.end()));
  }
  return blocks;
}

}  // namespace hystcan::app
