#include "can/protocol/e2e.h"

#include <boost/crc.hpp>
#include <utility>

namespace hystcan::can {
namespace {

using J1850 = boost::crc_optimal<8, 0x1D, 0xFF, 0xFF, false, false>;
using H2F = boost::crc_optimal<8, 0x2F, 0xFF, 0xFF, false, false>;
using Ccitt = boost::crc_optimal<16, 0x1021, 0xFFFF, 0, false, false>;

template <class Sum>
typename Sum::value_type crc_of_bytes(std::span<const std::uint8_t> bytes) {
  Sum crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

/// Computes the CRC of the data id, then of all bytes except the CRC bytes, which begin at `crc_byte`.
template <class Sum>
std::uint16_t crc_of_frame(std::span<const std::uint8_t> id, std::span<const std::uint8_t> payload,
                           std::size_t crc_byte) {
  Sum crc;
  crc.process_bytes(id.data(), id.size());
  crc.process_bytes(payload.data(), crc_byte);
  const auto rest = payload.subspan(crc_byte + Sum::bit_count / 8);
  crc.process_bytes(rest.data(), rest.size());
  return crc.checksum();
}

}  // namespace

std::uint8_t crc8_j1850(std::span<const std::uint8_t> bytes) { return crc_of_bytes<J1850>(bytes); }
std::uint8_t crc8_8h2f(std::span<const std::uint8_t> bytes) { return crc_of_bytes<H2F>(bytes); }
std::uint16_t crc16(std::span<const std::uint8_t> bytes) { return crc_of_bytes<Ccitt>(bytes); }

std::uint16_t Protection::crc_of(const Frame& frame) const {
  const bool is_number = data_id.kind == DataId::Kind::number;
  const std::uint32_t id = is_number ? data_id.number : frame.id;
  const std::array<std::uint8_t, 4> bytes = {
      static_cast<std::uint8_t>(id), static_cast<std::uint8_t>(id >> 8U),
      static_cast<std::uint8_t>(id >> 16U), static_cast<std::uint8_t>(id >> 24U)};
  std::span<const std::uint8_t> covered(bytes.data(), !is_number && frame.extended ? 4 : 2);
  if (data_id.kind == DataId::Kind::none) covered = {};
  const std::size_t crc_byte = crc->first_byte();
  switch (polynomial) {
    case Crc::sae_j1850:
      return crc_of_frame<J1850>(covered, frame.payload(), crc_byte);
    case Crc::autosar_8h2f:
      return crc_of_frame<H2F>(covered, frame.payload(), crc_byte);
    case Crc::crc16:
      break;
  }
  return crc_of_frame<Ccitt>(covered, frame.payload(), crc_byte);
}

void E2eProtector::seal(Frame& frame) {
  if (protection_.counter) protection_.counter->pack_raw(counter_++, frame.payload());
  if (protection_.crc) protection_.crc->pack_raw(protection_.crc_of(frame), frame.payload());
}

E2eChecker::E2eChecker(const Protection& protection, std::uint8_t length, bool extended, bool fd)
    : protection_(protection),
      length_(wire_length(length)),
      kind_(wire_kind(length, fd)),
      extended_(extended) {}

std::optional<Rejection> E2eChecker::check(const Frame& frame) {
  const auto reject = [this](Rejection cause) {
    ++rejected_[static_cast<std::size_t>(cause)];
    return cause;
  };
  if (frame.kind != kind_) return reject(Rejection::wrong_kind);
  if (frame.extended != extended_) return reject(Rejection::extended_id);
  if (frame.length != length_) return reject(Rejection::wrong_length);
  if (protection_.crc) {
    const unsigned mask = protection_.polynomial == Crc::crc16 ? 0xFFFF : 0xFF;
    const auto stated = static_cast<std::uint16_t>(protection_.crc->unpack_raw(frame.payload()) & mask);
    if (stated != protection_.crc_of(frame)) return reject(Rejection::wrong_crc);
  }
  if (repeats(frame)) return reject(Rejection::repeated_counter);
  ++accepted_;
  return std::nullopt;
}

bool E2eChecker::repeats(const Frame& frame) {
  if (!protection_.counter) return false;
  const std::int64_t counter = protection_.counter->unpack_raw(frame.payload());
  if (last_counter_ == counter) return true;
  last_counter_ = counter;
  return false;
}

RejectedFrames rejected_frames(std::string message, const E2eChecker& checker) {
  RejectedFrames rejected{.message = std::move(message)};
  for (std::size_t i = 0; i < rejection_count; ++i)
    rejected.by_cause[i] = checker.rejected(static_cast<Rejection>(i));
  return rejected;
}

std::string describe(const RejectedFrames& rejected) {
  std::string text;
  for (std::size_t i = 0; i < rejection_count; ++i) {
    if (rejected.by_cause[i] == 0) continue;
    text += text.empty() ? rejected.message + ": rejected: " : std::string(", ");
    text += std::to_string(rejected.by_cause[i]) + ' ' + std::string(to_string(static_cast<Rejection>(i)));
  }
  return text;
}

}  // namespace hystcan::can
