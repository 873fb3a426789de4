#include "can/frame_bits.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace hystcan::can {
namespace {

// The functions below process whole bytes of the part of a frame that can have stuff bits. Padding bits fill
// the front of the first byte. For the stuff bits, the padding alternates and ends recessive, like an idle
// bus, so that it causes no stuff bit. For the CRC, the padding is zeros, which do not change a CRC that
// starts at 0.

constexpr unsigned end_bits = 9 + interframe_bits;  // ACK slot and delimiter, end of frame, interframe space

constexpr std::array<std::uint16_t, 256> make_crc15_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned remainder = byte << 7U;
    for (int bit = 0; bit < 8; ++bit)
      remainder = (remainder & 0x4000U) != 0 ? (remainder << 1U) ^ 0x4599U : remainder << 1U;
    table[byte] = static_cast<std::uint16_t>(remainder & 0x7FFFU);
  }
  return table;
}
constexpr auto crc15_table = make_crc15_table();

// The result of sending one byte. The state of a transmitter that inserts stuff bits consists of the last bit
// (0 or 1) and of the run length: the number of equal bits at the end of the sent bits, 1..4.
struct Stuffing {
  std::uint8_t state;    // state after the byte: 4 * last bit + run length - 1
  std::uint8_t stuffed;  // number of stuff bits inserted within the byte
};
constexpr unsigned stuffing_states = 8;

constexpr Stuffing stuff_byte(unsigned state, unsigned byte) {
  unsigned bit = state / 4;
  unsigned run = state % 4 + 1;
  unsigned stuffed = 0;
  for (unsigned mask = 0x80; mask != 0; mask >>= 1U) {
    const unsigned next = (byte & mask) != 0 ? 1 : 0;
    run = next == bit ? run + 1 : 1;
    bit = next;
    if (run == 5) {
      ++stuffed;
      bit = 1 - bit;
      run = 1;
    }
  }
  return {static_cast<std::uint8_t>(4 * bit + run - 1), static_cast<std::uint8_t>(stuffed)};
}

constexpr std::array<std::array<Stuffing, 256>, stuffing_states> make_stuffing_table() {
  std::array<std::array<Stuffing, 256>, stuffing_states> table{};
  for (unsigned state = 0; state < stuffing_states; ++state) {
    for (unsigned byte = 0; byte < 256; ++byte) table[state][byte] = stuff_byte(state, byte);
  }
  return table;
}
constexpr auto stuffing_table = make_stuffing_table();

class StuffCounter {
 public:
  void add(std::uint8_t byte) {
    const Stuffing step = stuffing_table[state_][byte];
    state_ = step.state;
    count_ += step.stuffed;
  }
  unsigned count() const { return count_; }
  /// Returns true if a stuff bit was inserted after the last added bit. `bit`: the value of this last bit.
  bool ends_stuffed(unsigned bit) const { return state_ / 4U != bit; }

 private:
  std::uint8_t state_ = 4;  ///< Stuffing::state of an idle bus: last bit recessive, run length 1
  unsigned count_ = 0;
};

struct Header {
  std::uint64_t bits;
  unsigned length;

  unsigned bytes() const { return (length + 7) / 8; }
  /// Returns alternating bits at the positions above the highest header bit. The header is processed in whole
  /// bytes, and these bits fill the unused high bits of its first byte. The caller does not use the bits
  /// above this byte.
  std::uint64_t padding() const { return 0x55ULL << length; }
};

Header classical_header(const Frame& frame) {
  const std::uint64_t remote = frame.kind == FrameKind::remote ? 1 : 0;
  const std::uint64_t id = frame.id;
  const std::uint64_t control = remote << 6U | std::min<std::uint64_t>(frame.length, 8);
  if (!frame.extended) return {id << 7U | control, 19};
  return {id >> 18U << 27U | std::uint64_t{3} << 25U | (id & 0x3FFFFU) << 7U | control, 39};
}

FrameBits classical_bits(const Frame& frame) {
  const Header header = classical_header(frame);
  StuffCounter stuffing;
  unsigned crc = 0;
  const auto add = [&](std::uint8_t content, std::uint8_t on_wire) {
    crc = (crc << 8U ^ crc15_table[(crc >> 7U ^ content) & 0xFFU]) & 0x7FFFU;
    stuffing.add(on_wire);
  };
  for (unsigned shift = 8 * header.bytes(); shift != 0;) {
    shift -= 8;
    add(static_cast<std::uint8_t>(header.bits >> shift),
        static_cast<std::uint8_t>((header.bits | header.padding()) >> shift));
  }
  const std::size_t bytes = frame.kind == FrameKind::remote ? 0 : std::min<std::size_t>(frame.length, 8);
  for (std::size_t i = 0; i < bytes; ++i) add(frame.data[i], frame.data[i]);
  // The CRC has 15 bits. A 16th bit fills its second byte. This bit differs from the last CRC bit, so that it
  // causes no stuff bit.
  const unsigned tail = crc << 1U | (~crc & 1U);
  stuffing.add(static_cast<std::uint8_t>(tail >> 8U));
  stuffing.add(static_cast<std::uint8_t>(tail));
  const auto content_bits = static_cast<unsigned>(header.length + 8 * bytes + 15);
  return {.head = content_bits + stuffing.count() + 1 + end_bits};  // + 1: the bit of the CRC delimiter
}

/// Returns the length code (DLC) of a CAN FD payload.
std::uint64_t fd_length_code(std::uint8_t length) {
  const auto place = std::ranges::find(fd_lengths, length) - fd_lengths.begin();
  return length <= 8 ? length : 9 + static_cast<std::uint64_t>(place);
}

/// Number of header bits after the reserved bit `res`: bit-rate switch (BRS), error state (ESI) and four bits
/// of the length code.
constexpr unsigned fd_control_bits = 6;

Header fd_header(const Frame& frame) {
  const std::uint64_t id = frame.id;
  const auto flags = static_cast<unsigned>(frame.fd_flags);
  const std::uint64_t control = std::uint64_t{1} << 7U |  // FDF (FD format) is 1, the next bit (res) is 0
                                ((flags & fd_bit_rate_switch) != 0 ? 1U << 5U : 0U) |
                                ((flags & fd_error_state) != 0 ? 1U << 4U : 0U) |
                                fd_length_code(wire_length(frame.length));
  if (!frame.extended) return {id << 10U | control, 22};
  return {id >> 18U << 29U | std::uint64_t{3} << 27U | (id & 0x3FFFFU) << 9U | control, 41};
}

void add(const Header& header, StuffCounter& stuffing) {
  const std::uint64_t on_wire = header.bits | header.padding();
  for (unsigned shift = 8 * header.bytes(); shift != 0;) {
    shift -= 8;
    stuffing.add(static_cast<std::uint8_t>(on_wire >> shift));
  }
}

FrameBits fd_bits(const Frame& frame) {
  const std::uint8_t length = wire_length(frame.length);
  const Header header = fd_header(frame);
  StuffCounter stuffing;
  add(header, stuffing);
  auto last = static_cast<std::uint8_t>(header.bits);
  for (std::size_t i = 0; i < length; ++i) {
    last = i < frame.length ? frame.data[i] : std::uint8_t{0};
    stuffing.add(last);
  }
  // The stuff count begins with a fixed stuff bit. If the last data bit needs a stuff bit, the fixed stuff
  // bit replaces it.
  const unsigned stuffed = stuffing.count() - (stuffing.ends_stuffed(last & 1U) ? 1 : 0);
  // Number of bits in the stuff count, the CRC and the fixed stuff bits.
  const unsigned checked_bits = length <= 16 ? 4 + 17 + 6 : 4 + 21 + 7;
  const unsigned switched_bits = fd_control_bits - 1 + 8U * length + checked_bits + 1;  // + 1: CRC delimiter
  const unsigned head_bits = header.length - (fd_control_bits - 1);
  if ((frame.fd_flags & fd_bit_rate_switch) == 0)
    return {.head = head_bits + stuffed + switched_bits + end_bits};
  // The reserved bit `res` is dominant; the bits before it (FDF) and after it (BRS) are recessive. Therefore
  // no stuff bit follows `res` or BRS.
  StuffCounter head_stuffing;
  add({header.bits >> fd_control_bits, header.length - fd_control_bits}, head_stuffing);
  return {.head = head_bits + head_stuffing.count(),
          .data = switched_bits + stuffed - head_stuffing.count(),
          .tail = end_bits};
}

}  // namespace

BitCount FrameBits::first(unsigned bits) const {
  const unsigned before = std::min(bits, head);
  const unsigned within = std::min(bits - before, data);
  return {.nominal = bits - within, .data = within};
}

FrameBits frame_bits(const Frame& frame) {
  return frame.kind == FrameKind::fd ? fd_bits(frame) : classical_bits(frame);
}

Duration transmission_time(const BitCount& bits, const BitRates& rates) {
  const auto time_of = [](std::int64_t count, std::int64_t rate_bit_per_s) {
    return Duration{(count * 1'000'000'000 + rate_bit_per_s - 1) / rate_bit_per_s};
  };
  if (rates.data_bit_per_s == 0) return time_of(bits.total(), rates.nominal_bit_per_s);
  return time_of(bits.nominal, rates.nominal_bit_per_s) + time_of(bits.data, rates.data_bit_per_s);
}

}  // namespace hystcan::can
