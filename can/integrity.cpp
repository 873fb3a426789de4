#include "can/integrity.h"

namespace hystcan::can {
namespace {

constexpr std::uint8_t polynomial = 0x1D;
constexpr std::uint8_t initial = 0xFF;
constexpr std::uint8_t final_xor = 0xFF;

constexpr std::array<std::uint8_t, 256> make_table() {
  std::array<std::uint8_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned remainder = byte;
    for (int bit = 0; bit < 8; ++bit) {
      remainder = (remainder & 0x80U) != 0 ? (remainder << 1U) ^ polynomial : remainder << 1U;
    }
    table[byte] = static_cast<std::uint8_t>(remainder);
  }
  return table;
}

constexpr std::array<std::uint8_t, 256> table = make_table();

std::uint8_t extend_crc(std::uint8_t crc, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) crc = table[crc ^ byte];
  return crc;
}

std::uint8_t crc_of(const Frame& frame) {
  const std::array<std::uint8_t, 2> id = {static_cast<std::uint8_t>(frame.id),
                                          static_cast<std::uint8_t>(frame.id >> 8U)};
  const auto covered = frame.payload().first(frame.length - std::size_t{1});
  return extend_crc(extend_crc(initial, id), covered) ^ final_xor;
}

}  // namespace

std::uint8_t crc8_j1850(std::span<const std::uint8_t> bytes) {
  return extend_crc(initial, bytes) ^ final_xor;
}

std::string_view to_string(Rejection rejection) {
  switch (rejection) {
    case Rejection::wrong_kind:
      return "not a data frame";
    case Rejection::extended_id:
      return "wrong identifier type";
    case Rejection::wrong_length:
      return "wrong length";
    case Rejection::wrong_crc:
      return "wrong CRC";
    case Rejection::repeated_counter:
      return "repeated counter";
  }
  return "unknown";
}

void Sealer::seal(Frame& frame) {
  protection_.counter.pack_raw(counter_, frame.payload());
  ++counter_;
  protection_.crc.pack_raw(crc_of(frame), frame.payload());
}

Checker::Checker(Protection protection, std::uint8_t length, bool extended)
    : protection_(protection), length_(length), extended_(extended) {}

std::optional<Rejection> Checker::check(const Frame& frame) {
  const auto reject = [this](Rejection cause) {
    ++rejected_[static_cast<std::size_t>(cause)];
    return cause;
  };
  if (frame.kind != FrameKind::data) return reject(Rejection::wrong_kind);
  if (frame.extended != extended_) return reject(Rejection::extended_id);
  if (frame.length != length_) return reject(Rejection::wrong_length);
  const auto stated_crc = static_cast<std::uint8_t>(protection_.crc.unpack_raw(frame.payload()));
  if (stated_crc != crc_of(frame)) return reject(Rejection::wrong_crc);
  const std::int64_t counter = protection_.counter.unpack_raw(frame.payload());
  if (last_counter_ == counter) return reject(Rejection::repeated_counter);
  last_counter_ = counter;
  ++accepted_;
  return std::nullopt;
}

}  // namespace hystcan::can
