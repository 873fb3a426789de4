#include "app/page/stream_rows.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>

namespace hystcan::app {

RowLayout RowLayout::of(const nlohmann::json& greeting) {
  const nlohmann::json& columns = greeting.at("columns");
  RowLayout layout{.columns = columns.size()};
  bool has_axis = false;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string name = columns[i].at("name");
    if (name == "axis") {
      layout.axis = i;
      has_axis = true;
    }
    if (name == "state" || name == "fault") layout.states.push_back(i);
    if (name == "limits") layout.bits = i;
  }
  if (!has_axis) throw std::runtime_error("it has no column \"axis\"");
  return layout;
}

std::size_t RowDecimator::bucket_for(double rate_Hz, double most_Hz) {
  if (!(rate_Hz > most_Hz)) return 1;
  return static_cast<std::size_t>(std::ceil(2.0 * rate_Hz / most_Hz));  // each bucket becomes two rows
}

void RowDecimator::put(std::span<const double> row) {
  if (bucket_ <= 2) {
    out_.insert(out_.end(), row.begin(), row.end());
    return;
  }
  Bucket& bucket = open_[static_cast<std::size_t>(row[layout_.axis])];
  if (bucket.rows > 0 && is_another_state(bucket, row)) empty(bucket);
  join(bucket, row);
  if (++bucket.rows == bucket_) empty(bucket);
}

bool RowDecimator::is_another_state(const Bucket& bucket, std::span<const double> row) const {
  return std::ranges::any_of(layout_.states, [&](std::size_t i) { return bucket.least[i] != row[i]; });
}

void RowDecimator::join(Bucket& bucket, std::span<const double> row) const {
  if (bucket.rows == 0) {
    bucket.least.assign(row.begin(), row.end());
    bucket.largest = bucket.least;
    return;
  }
  for (std::size_t i = 0; i < layout_.columns; ++i) {
    if (i == layout_.bits) {
      bucket.largest[i] =
          static_cast<double>(static_cast<unsigned>(bucket.largest[i]) | static_cast<unsigned>(row[i]));
      continue;
    }
    bucket.least[i] = std::fmin(bucket.least[i], row[i]);  // prefers a number to NaN, as fmax does
    bucket.largest[i] = std::fmax(bucket.largest[i], row[i]);
  }
}

void RowDecimator::empty(Bucket& bucket) {
  out_.insert(out_.end(), bucket.least.begin(), bucket.least.end());
  if (bucket.rows > 1) out_.insert(out_.end(), bucket.largest.begin(), bucket.largest.end());
  bucket.rows = 0;
}

std::vector<double> RowDecimator::take() { return std::exchange(out_, {}); }

}  // namespace hystcan::app
