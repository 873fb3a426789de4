#include "app/page/page_stream.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace hystcan::app {
namespace {

constexpr double history_s = 60.0;
constexpr double shortest_history_s = 12.0;  // what the longest capture needs, and some
constexpr double most_history_rows = 200'000.0;
constexpr double rows_of_the_past = 4'000.0;
constexpr std::size_t rows_of_a_block = 100;
constexpr double fastest_Hz = 1e5;
constexpr std::size_t most_axes = 64;

RowBlock block_of(std::vector<double> values) {
  return values.empty() ? nullptr : std::make_shared<const std::vector<double>>(std::move(values));
}

}  // namespace

PageStream::PageStream(std::string name, std::uint32_t kind, Hooks hooks)
    : name_(std::move(name)), kind_(kind), hooks_(std::move(hooks)) {}

void PageStream::begun(const nlohmann::json& greeting) {
  RowLayout layout = RowLayout::of(greeting);
  const double rate = greeting.at("rate_Hz").get<double>();
  const std::size_t axes = greeting.at("axes").size();
  if (greeting.at("stream") != name_) throw std::runtime_error("it is the stream of another process");
  if (axes == 0 || axes > most_axes || !(rate > 0.0 && rate <= fastest_Hz))
    throw std::runtime_error("its axes or its rate are not those of a stream");
  layout_ = std::move(layout);
  axes_ = axes;
  const double rows_per_s = rate * static_cast<double>(axes);
  const double rows =
      std::clamp(history_s * rows_per_s, 1.0, std::max(most_history_rows, shortest_history_s * rows_per_s));
  history_.emplace(layout_.columns, static_cast<std::size_t>(rows));
  greeting_ = greeting;
  lanes_.clear();
  set_rates(std::exchange(rates_, {}));
  hooks_.changed();
}

void PageStream::received(std::span<const double> values, std::uint32_t lost) {
  for (; values.size() >= layout_.columns; values = values.subspan(layout_.columns)) {
    const std::span<const double> row = values.first(layout_.columns);
    if (!(row[layout_.axis] >= 0.0 && row[layout_.axis] < static_cast<double>(axes_))) continue;
    history_->put(row);
    for (auto& [rate, lane] : lanes_) lane.decimator.put(row);
    hooks_.row(row);
  }
  for (auto& [rate, lane] : lanes_) lane.rows = block_of(lane.decimator.take());
  hooks_.batch(lost);
}

void PageStream::ended(const std::string& reason) {
  const bool was_there = history_.has_value();
  history_.reset();
  greeting_ = nullptr;
  lanes_.clear();
  if (std::exchange(reason_, reason) != reason || was_there) hooks_.changed();
}

nlohmann::json PageStream::message() const {
  nlohmann::json message{{"type", "stream"}, {"name", name_}, {"greeting", greeting_}};
  if (greeting_.is_null()) message["reason"] = reason_;
  return message;
}

PageStream::Lane PageStream::lane_for(double rate) const {
  return {RowDecimator(layout_, RowDecimator::bucket_for(rate_Hz(), rate))};
}

void PageStream::set_rates(const std::set<double>& rates) {
  rates_ = rates;
  if (!is_there()) return;
  std::erase_if(lanes_, [&](const auto& lane) { return !rates_.contains(lane.first); });
  for (const double rate : rates_)
    if (!lanes_.contains(rate)) lanes_.emplace(rate, lane_for(rate));
}

RowBlock PageStream::rows_at(double rate) const {
  const auto lane = lanes_.find(rate);
  return lane == lanes_.end() ? nullptr : lane->second.rows;
}

std::vector<RowBlock> PageStream::past() const {
  const auto rows = static_cast<double>(history_->end() - history_->first());
  RowDecimator decimator(layout_, RowDecimator::bucket_for(rows, rows_of_the_past));
  for (std::uint64_t i = history_->first(); i < history_->end(); ++i) decimator.put(history_->row(i));
  const std::vector<double> values = decimator.take();
  std::vector<RowBlock> blocks;
  for (auto rest = std::span(values); !rest.empty();
       rest = rest.subspan(std::min(rest.size(), rows_of_a_block * layout_.columns))) {
    const auto block = rest.first(std::min(rest.size(), rows_of_a_block * layout_.columns));
    blocks.push_back(std::make_shared<const std::vector<double>>(block.begin(), block.end()));
  }
  return blocks;
}

}  // namespace hystcan::app
