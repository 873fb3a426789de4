#include "can/dbc/signal_codec.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

namespace hystcan::can {
namespace {

constexpr double two_to_63 = 9223372036854775808.0;
constexpr std::size_t window_bytes = sizeof(std::uint64_t);

std::uint64_t load_window(const std::uint8_t* bytes, ByteOrder order) {
  std::uint64_t window;
  std::memcpy(&window, bytes, sizeof window);
  const bool swap = (order == ByteOrder::big_endian) == (std::endian::native == std::endian::little);
  return swap ? __builtin_bswap64(window) : window;
}

void store_window(std::uint64_t window, std::uint8_t* bytes, ByteOrder order) {
  const bool swap = (order == ByteOrder::big_endian) == (std::endian::native == std::endian::little);
  if (swap) window = __builtin_bswap64(window);
  std::memcpy(bytes, &window, sizeof window);
}

std::uint64_t low_bits(unsigned count) { return ~std::uint64_t{0} >> (64U - count); }

}  // namespace

SignalCodec::SignalCodec(const Signal& signal)
    : placement_(place(signal)),
      length_(static_cast<std::uint8_t>(signal.length)),
      byte_order_(signal.byte_order),
      is_signed_(signal.is_signed && signal.value_type == ValueType::integer),
      value_type_(signal.value_type),
      scale_(signal.scale),
      offset_(signal.offset) {
  if (value_type_ == ValueType::integer) {
    set_integer_range(signal);
  } else {
    set_float_range(signal);
  }
}

void SignalCodec::check(const Signal& signal) {
  const unsigned length = signal.length;
  const bool fits = signal.value_type == ValueType::integer   ? length >= 1 && length <= 64
                    : signal.value_type == ValueType::float32 ? length == 32
                    : signal.value_type == ValueType::float64 ? length == 64
                                                              : false;
  if (fits) return;
  throw std::invalid_argument("signal " + signal.name + " has " + std::to_string(length) +
                              " bits, expected 1 to 64 bits (an IEEE 754 number: 32 or 64 bits)");
}

SignalCodec::Placement SignalCodec::place(const Signal& signal) {
  check(signal);
  const bool little = signal.byte_order == ByteOrder::little_endian;
  // Index of the first bit. In a big-endian signal, each byte is counted from its highest bit.
  const std::uint32_t first = little ? signal.start_bit : signal.start_bit ^ 7U;
  const std::uint32_t last = first + signal.length - 1;
  return {first / 8, last / 8, static_cast<std::uint8_t>(little ? first % 8 : 7 - last % 8)};
}

void SignalCodec::set_integer_range(const Signal& signal) {
  const double span = std::ldexp(1.0, signal.length);
  raw_low_ = is_signed_ ? -span / 2 : 0.0;
  const double raw_end = is_signed_ ? span / 2 : span;
  raw_high_ = std::min(raw_end - 1.0, std::nextafter(raw_end, 0.0));

  minimum_ = std::min(raw_low_ * scale_, raw_high_ * scale_) + offset_;
  maximum_ = std::max(raw_low_ * scale_, raw_high_ * scale_) + offset_;
  if (signal.minimum != 0.0 || signal.maximum != 0.0) {
    minimum_ = std::max(minimum_, signal.minimum);
    maximum_ = std::min(maximum_, signal.maximum);
  }
  const double ulps = 4 * std::numeric_limits<double>::epsilon();
  const double slack = 1e-6 * std::abs(scale_) + ulps * std::abs(offset_);
  accepted_from_ = minimum_ - slack - ulps * std::abs(minimum_);
  accepted_to_ = maximum_ + slack + ulps * std::abs(maximum_);
  if (scale_ == 0.0) accepted_from_ = std::numeric_limits<double>::infinity();
}

void SignalCodec::set_float_range(const Signal& signal) {
  raw_high_ = value_type_ == ValueType::float32 ? static_cast<double>(std::numeric_limits<float>::max())
                                                : std::numeric_limits<double>::max();
  raw_low_ = -raw_high_;
  minimum_ = std::numeric_limits<double>::lowest();
  maximum_ = std::numeric_limits<double>::max();
  if (signal.minimum != 0.0 || signal.maximum != 0.0) {
    minimum_ = signal.minimum;
    maximum_ = signal.maximum;
  }
  accepted_from_ = scale_ == 0.0 ? std::numeric_limits<double>::infinity() : minimum_;
  accepted_to_ = maximum_;
}

std::uint64_t SignalCodec::load(std::span<const std::uint8_t> payload) const {
  const auto [first, last, shift] = placement_;
  assert(payload.size() > last);
  if (payload.size() >= window_bytes && last - first < window_bytes) {
    const std::size_t base = std::min<std::size_t>(first, payload.size() - window_bytes);
    const std::size_t before =
        byte_order_ == ByteOrder::little_endian ? first - base : base + window_bytes - 1 - last;
    return load_window(payload.data() + base, byte_order_) >> (8 * before + shift) & low_bits(length_);
  }
  const bool little = byte_order_ == ByteOrder::little_endian;
  std::uint64_t bits = payload[little ? first : last] >> shift;
  for (unsigned step = 1; step <= last - first; ++step) {
    bits |= std::uint64_t{payload[little ? first + step : last - step]} << (8 * step - shift);
  }
  return bits & low_bits(length_);
}

void SignalCodec::store(std::uint64_t bits, std::span<std::uint8_t> payload) const {
  const auto [first, last, shift] = placement_;
  assert(payload.size() > last);
  const std::uint64_t mask = low_bits(length_);
  bits &= mask;
  if (payload.size() >= window_bytes && last - first < window_bytes) {
    const std::size_t base = std::min<std::size_t>(first, payload.size() - window_bytes);
    const std::size_t before =
        byte_order_ == ByteOrder::little_endian ? first - base : base + window_bytes - 1 - last;
    const std::size_t by = 8 * before + shift;
    const std::uint64_t others = load_window(payload.data() + base, byte_order_) & ~(mask << by);
    store_window(others | bits << by, payload.data() + base, byte_order_);
    return;
  }
  const bool little = byte_order_ == ByteOrder::little_endian;
  for (unsigned step = 0; step <= last - first; ++step) {
    std::uint8_t& byte = payload[little ? first + step : last - step];
    const std::uint64_t field = step == 0 ? bits << shift : bits >> (8 * step - shift);
    const std::uint64_t hole = step == 0 ? mask << shift : mask >> (8 * step - shift);
    byte = static_cast<std::uint8_t>((byte & ~hole) | field);
  }
}

std::int64_t SignalCodec::unpack_raw(std::span<const std::uint8_t> payload) const {
  const std::uint64_t bits = load(payload);
  if (!is_signed_) return static_cast<std::int64_t>(bits);
  const unsigned unused = 64U - length_;
  return static_cast<std::int64_t>(bits << unused) >> unused;
}

double SignalCodec::unpack(std::span<const std::uint8_t> payload) const {
  const std::int64_t raw = unpack_raw(payload);
  double value = static_cast<double>(raw);
  if (value_type_ == ValueType::float32) {
    value = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)));
  } else if (value_type_ == ValueType::float64) {
    value = std::bit_cast<double>(raw);
  } else if (raw < 0 && !is_signed_) {
    value = static_cast<double>(static_cast<std::uint64_t>(raw));
  }
  return value * scale_ + offset_;
}

void SignalCodec::pack_raw(std::int64_t raw, std::span<std::uint8_t> payload) const {
  store(static_cast<std::uint64_t>(raw), payload);
}

std::uint64_t SignalCodec::bits_of(double raw) const {
  if (value_type_ == ValueType::float32) return std::bit_cast<std::uint32_t>(static_cast<float>(raw));
  if (value_type_ == ValueType::float64) return std::bit_cast<std::uint64_t>(raw);
  if (raw >= two_to_63) return static_cast<std::uint64_t>(raw);
  return static_cast<std::uint64_t>(std::llrint(raw));
}

bool SignalCodec::pack(double physical, std::span<std::uint8_t> payload) const {
  if (!std::isfinite(physical) || physical < accepted_from_ || physical > accepted_to_) return false;
  double raw = (physical - offset_) / scale_;
  if (value_type_ == ValueType::integer) {
    raw = std::clamp(raw, raw_low_, raw_high_);
  } else if (!(raw >= raw_low_ && raw <= raw_high_)) {
    return false;
  }
  store(bits_of(raw), payload);
  return true;
}

}  // namespace hystcan::can
