#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <string>

#include "can/sim/sim_bus.h"

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
    RC_ASSERT(frame_bits(frame) == written_out(frame));
  }));
}

TEST(FrameBits, AgreeWithTheStringOfBitsForEveryStandardIdentifier) {
  for (std::uint32_t id = 0; id < 0x800; ++id) {
    for (std::uint8_t length = 0; length <= 8; ++length) {
      const Frame frame{.id = id, .length = length};
      ASSERT_EQ(frame_bits(frame), written_out(frame)) << id << ' ' << int{length};
    }
  }
}

TEST(FrameBits, AgreeWithCanbusloadOfCanUtils) {  // canbusload -e
  EXPECT_EQ(frame_bits({.id = 0x201, .length = 8, .data = {0x4E, 0x61, 0xBC, 0x00, 0x01, 0x07, 0x03, 0xD9}}),
            118U);
  EXPECT_EQ(frame_bits({.id = 0x000, .length = 8}), 127U);
  EXPECT_EQ(frame_bits({.id = 0x7FF, .length = 3, .data = {0xFF, 0xFF, 0xFF}}), 79U);
  EXPECT_EQ(frame_bits({.id = 0x18FEEDFE, .extended = true, .length = 2, .data = {0xAB, 0xCD}}), 86U);
}

TEST(FrameBits, StayWithinTheBoundsOfTheStandard) {
  Frame frame{.id = 0x555, .length = 8};
  frame.data.fill(0x55);
  EXPECT_GE(frame_bits(frame), 111U);
  Frame worst{.id = 0x000, .length = 8};
  EXPECT_LE(frame_bits(worst), 111U + 24U);
  EXPECT_GT(frame_bits(worst), 111U + 10U);
}

TEST(FrameBits, GrowWithTheLengthCodeOfAnFdFrame) {
  Frame frame{.id = 0x555, .kind = FrameKind::fd, .length = 64};
  frame.data.fill(0x55);
  // SOF 1, arbitration and control 21, data 512, stuff count 4, CRC 21, fixed stuff bits 7, tail 10,
  // interframe 3. There are no five equal bits in a row.
  EXPECT_EQ(frame_bits(frame), 1U + 21U + 512U + 4U + 21U + 7U + 10U + 3U);
  const unsigned at_64 = frame_bits(frame);
  frame.length = 49;
  EXPECT_LE(frame_bits(frame), at_64 + 15 * 2) << "49 bytes take 64 bytes on the wire";
  EXPECT_GE(frame_bits(frame), at_64);
}

}  // namespace
}  // namespace hystcan::can::frame_bits_test
