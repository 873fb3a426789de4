#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <string>

#include "can/frame_bits.h"

namespace hystcan::can::frame_bits_test {
namespace {

std::string bits(std::uint32_t value, unsigned count) {
  std::string text;
  while (count-- > 0) text += (value >> count & 1U) != 0 ? '1' : '0';
  return text;
}

std::string crc15(const std::string& content) {
  unsigned reg = 0;
  for (const char bit : content) {
    const unsigned next = (bit == '1' ? 1U : 0U) ^ (reg >> 14U & 1U);
    reg = reg << 1U & 0x7FFFU;
    if (next != 0) reg ^= 0x4599U;
  }
  return bits(reg, 15);
}

std::string stuffed(const std::string& content) {
  std::string wire;
  unsigned run = 0;
  for (const char bit : content) {
    run = !wire.empty() && wire.back() == bit ? run + 1 : 1;
    wire += bit;
    if (run == 5) {
      wire += bit == '0' ? '1' : '0';
      run = 1;
    }
  }
  return wire;
}

/// The oracle: the frame as a string of bits, with the fields of ISO 11898-1.
unsigned written_out(const Frame& frame) {
  const std::string remote = frame.kind == FrameKind::remote ? "1" : "0";
  std::string content = "0";
  if (frame.extended) {
    content += bits(frame.id >> 18U, 11) + "11" + bits(frame.id & 0x3FFFFU, 18) + remote + "00";
  } else {
    content += bits(frame.id, 11) + remote + "00";
  }
  content += bits(frame.length, 4);
  if (frame.kind == FrameKind::data) {
    for (const std::uint8_t byte : frame.payload()) content += bits(byte, 8);
  }
  const std::string wire = stuffed(content + crc15(content)) + "1" + "01" + "1111111" + "111";
  return static_cast<unsigned>(wire.size());
}

/// The oracle of CAN FD: the bits before, in and after the data phase, even if there is none. The contents of
/// stuff count and CRC do not matter: their stuff bits have fixed positions, before them and after each
/// fourth bit.
FrameBits fd_written_out(const Frame& frame) {
  std::string head = "0";
  head +=
      frame.extended ? bits(frame.id >> 18U, 11) + "11" + bits(frame.id & 0x3FFFFU, 18) : bits(frame.id, 11);
  head += frame.extended ? "010" : "0010";  // RRS, IDE of a standard frame, FDF, res
  const auto length = frame.length;
  const unsigned code = length <= 8 ? length : length <= 24 ? 6U + length / 4U : 11U + length / 16U;
  const bool switches = (frame.fd_flags & fd_bit_rate_switch) != 0;
  std::string rest = (switches ? "1" : "0") +
                     std::string((frame.fd_flags & fd_error_state) != 0 ? "1" : "0") + bits(code, 4);
  for (const std::uint8_t byte : frame.payload()) rest += bits(byte, 8);
  // A stuff bit after the last bit would be at the position of the first fixed one.
  const auto both = stuffed(head + rest.substr(0, rest.size() - 1)).size() + 1;
  const auto before = stuffed(head).size() + 1;  // BRS
  std::string checked = std::string(4, '0') + std::string(length <= 16 ? 17 : 21, '0');
  for (std::size_t at = 0; at < checked.size(); at += 5) checked.insert(at, "1");
  return {.head = static_cast<unsigned>(before),
          .data = static_cast<unsigned>(both - before + checked.size() + 1),
          .tail = 1 + 1 + 7 + 3};
}

Frame any_fd_frame() {
  Frame frame{.kind = FrameKind::fd, .fd_flags = fd_bit_rate_switch};
  frame.extended = *rc::gen::arbitrary<bool>();
  if (*rc::gen::arbitrary<bool>()) frame.fd_flags |= fd_error_state;
  frame.id = *rc::gen::inRange<std::uint32_t>(0, frame.extended ? 0x20000000 : 0x800);
  if (*rc::gen::arbitrary<bool>()) frame.id &= 0x1F8F'07FFU & *rc::gen::arbitrary<std::uint32_t>();
  if (!frame.extended) frame.id &= 0x7FFU;
  frame.length = wire_length(*rc::gen::inRange<std::uint8_t>(0, 65));
  const auto byte = *rc::gen::element<std::uint8_t>(0x00, 0xFF, 0x0F, 0xF8, 0x1E);
  const bool is_even = *rc::gen::arbitrary<bool>();
  for (std::uint8_t& at : frame.payload()) at = is_even ? byte : *rc::gen::arbitrary<std::uint8_t>();
  return frame;
}

TEST(FdFrameBits, AgreeWithTheFrameAsAStringOfBitsInEachPhase) {
  EXPECT_TRUE(rc::check([] {
    const Frame frame = any_fd_frame();
    const FrameBits counted = frame_bits(frame);
    const FrameBits expected = fd_written_out(frame);
    RC_ASSERT(counted.head == expected.head);
    RC_ASSERT(counted.data == expected.data);
    RC_ASSERT(counted.tail == expected.tail);
  }));
}

TEST(FdFrameBits, AgreeWithTheStringOfBitsForEveryLengthAndEveryFlag) {
  for (std::uint8_t length = 0; length <= 64; ++length)
    for (std::uint8_t flags = 0; flags < 4; ++flags)
      for (const std::uint8_t byte : std::initializer_list<std::uint8_t>{0x00, 0x40, 0xFF}) {
        Frame frame{.id = 0x2AA, .kind = FrameKind::fd, .length = wire_length(length), .fd_flags = flags};
        frame.data.fill(byte);
        ASSERT_EQ(frame_bits(frame).total(), fd_written_out(frame).total())
            << int{length} << ' ' << int{flags} << ' ' << int{byte};
      }
}

TEST(FdFrameBits, AreAllNominalWithoutBitRateSwitch) {
  Frame frame{.id = 0x2AA, .kind = FrameKind::fd, .length = 12};
  frame.data.fill(0x55);
  EXPECT_EQ(frame_bits(frame).all().data, 0U);
  EXPECT_EQ(frame_bits(frame).total(), 17U + 5U + 96U + 4U + 17U + 6U + 1U + 12U);
}

/// 0x2AA has no five equal bits in a row: 17 bits, ESI and length code 5, data 8 x 20, stuff count 4, CRC 21,
/// fixed stuff bits 7, delimiter 1, and 12 bits.
TEST(FdFrameBits, PassAtTheirOwnBitRateInTheDataPhase) {
  Frame frame{.id = 0x2AA, .kind = FrameKind::fd, .length = 20, .fd_flags = fd_bit_rate_switch};
  frame.data.fill(0x55);
  const BitRates rates{.nominal_bit_per_s = 1'000'000, .data_bit_per_s = 5'000'000};
  EXPECT_EQ(transmission_time(frame_bits(frame).all(), rates).count(),
            (17 + 12) * 1000 + (5 + 160 + 33) * 200);
  EXPECT_EQ(transmission_time(frame_bits(frame).all(), {}).count(), (17 + 12 + 5 + 160 + 33) * 1000);
}

TEST(TransmissionTime, IsRoundedUpToTheNextNanosecond) {
  EXPECT_EQ(transmission_time({.nominal = 1}, {.nominal_bit_per_s = 3}).count(), 333'333'334);
  EXPECT_EQ(transmission_time({.nominal = 3}, {.nominal_bit_per_s = 3}).count(), 1'000'000'000);
}

TEST(FrameBits, FirstGivesTheBitsOfEachPhaseUpToAPlace) {
  const FrameBits bits{.head = 20, .data = 100, .tail = 12};
  const auto first = [&](unsigned count) {
    return std::pair(bits.first(count).nominal, bits.first(count).data);
  };
  EXPECT_EQ(first(20), std::pair(20U, 0U));
  EXPECT_EQ(first(21), std::pair(20U, 1U));
  EXPECT_EQ(first(120), std::pair(20U, 100U));
  EXPECT_EQ(first(132), std::pair(32U, 100U));
}

TEST(FrameBits, AgreeWithTheFrameAsAStringOfBits) {
  EXPECT_TRUE(rc::check([] {
    Frame frame;
    frame.extended = *rc::gen::arbitrary<bool>();
    frame.id = *rc::gen::inRange<std::uint32_t>(0, frame.extended ? 0x20000000 : 0x800);
    frame.kind = *rc::gen::element(FrameKind::data, FrameKind::data, FrameKind::remote);
    frame.length = *rc::gen::inRange<std::uint8_t>(0, 9);
    for (std::uint8_t& byte : frame.payload()) {
      byte = *rc::gen::weightedOneOf<std::uint8_t>(
          {{2, rc::gen::element<std::uint8_t>(0x00, 0xFF, 0x0F, 0xF8, 0x1E)},
           {1, rc::gen::arbitrary<std::uint8_t>()}});
    }
    RC_ASSERT(frame_bits(frame).total() == written_out(frame));
  }));
}

TEST(FrameBits, AgreeWithCanbusloadOfCanUtils) {  // canbusload -e
  EXPECT_EQ(frame_bits({.id = 0x201, .length = 8, .data = {0x4E, 0x61, 0xBC, 0x00, 0x01, 0x07, 0x03, 0xD9}})
                .total(),
            118U);
  EXPECT_EQ(frame_bits({.id = 0x000, .length = 8}).total(), 127U);
  EXPECT_EQ(frame_bits({.id = 0x7FF, .length = 3, .data = {0xFF, 0xFF, 0xFF}}).total(), 79U);
  EXPECT_EQ(frame_bits({.id = 0x18FEEDFE, .extended = true, .length = 2, .data = {0xAB, 0xCD}}).total(), 86U);
}

TEST(FrameBits, GrowWithTheLengthCodeOfAnFdFrame) {
  Frame frame{.id = 0x555, .kind = FrameKind::fd, .length = 64};
  frame.data.fill(0x55);
  // SOF 1, arbitration and control 21, data 512, stuff count 4, CRC 21, fixed stuff bits 7, tail 10,
  // interframe 3. There are no five equal bits in a row.
  EXPECT_EQ(frame_bits(frame).total(), 1U + 21U + 512U + 4U + 21U + 7U + 10U + 3U);
  const unsigned at_64 = frame_bits(frame).total();
  frame.length = 49;
  EXPECT_LE(frame_bits(frame).total(), at_64 + 15 * 2) << "49 bytes take 64 bytes on the wire";
  EXPECT_GE(frame_bits(frame).total(), at_64);
}

// The identifier, then RTR in a standard frame; SRR and IDE, the rest of the identifier and RTR in an
// extended frame.
TEST(ArbitrationKey, HasTheBitsOfTheArbitrationFieldInTheirOrder) {
  EXPECT_EQ(arbitration_key(0x123, false), 0b00100100011'0'00000000000000000000U);
  EXPECT_EQ(arbitration_key(0x123, false, true), 0b00100100011'1'00000000000000000000U);
  EXPECT_EQ(arbitration_key(0x048E0001, true), 0b00100100011'11'100000000000000001'0U);
  EXPECT_EQ(arbitration_key(0x048E0001, true, true), 0b00100100011'11'100000000000000001'1U);
}

TEST(Identifier, HasElevenBitsOrTwentyNine) {
  EXPECT_TRUE(is_identifier(0x7FF, false));
  EXPECT_FALSE(is_identifier(0x800, false));
  EXPECT_TRUE(is_identifier(0x1FFF'FFFF, true));
  EXPECT_FALSE(is_identifier(0x2000'0000, true));
}

}  // namespace
}  // namespace hystcan::can::frame_bits_test
