// What the CRC of a message covers before its payload, against a CRC that is computed one bit at a time.
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "can/dbc/database.h"
#include "can/protocol/e2e.h"

namespace hystcan::can::data_id_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::uint8_t shifted_crc(const Bytes& bytes, unsigned polynomial) {
  unsigned reg = 0xFF;
  for (const unsigned byte : bytes)
    for (int bit = 7; bit >= 0; --bit) {
      const unsigned feedback = (reg >> 7U ^ byte >> bit) & 1U;
      reg = (reg << 1U & 0xFFU) ^ (feedback != 0 ? polynomial : 0U);
    }
  return static_cast<std::uint8_t>(reg ^ 0xFFU);
}

/// A signal of one byte in a message of eight.
SignalCodec byte_at(unsigned index) {
  const Database database = parse_dbc("BO_ 1 M: 8 Vector__XXX\n SG_ S : " + std::to_string(8 * index) +
                                          "|8@1+ (1,0) [0|255] \"\" Vector__XXX\n",
                                      "test.dbc");
  return SignalCodec(*database.find("M")->find("S"));
}

constexpr Frame frame_with(std::uint32_t id, bool extended) {
  Frame frame{.id = id, .extended = extended, .length = 8};
  std::iota(frame.data.begin(), frame.data.begin() + 8, std::uint8_t{0x31});
  return frame;
}

/// The CRC in the last byte of this frame, and the one of these bytes and the first seven of the payload.
void expect_covered(const Frame& frame, DataId data_id, Bytes covered) {
  for (std::uint8_t byte = 0x31; byte < 0x38; ++byte) covered.push_back(byte);
  const auto sealed = [&](Crc polynomial) {
    Frame copy = frame;
    E2eProtector({.crc = byte_at(7), .polynomial = polynomial, .data_id = data_id}).seal(copy);
    return copy.data[7];
  };
  EXPECT_EQ(sealed(Crc::sae_j1850), shifted_crc(covered, 0x1D));
  EXPECT_EQ(sealed(Crc::autosar_8h2f), shifted_crc(covered, 0x2F));
}

/// A CRC of 8 bits misses 2 wrong bits in a frame of 64 bytes (scripts/crc_distance).
TEST(Crc16OfAFrameOf64Bytes, FindsEveryTwoWrongBits) {
  const Database database = parse_dbc(
      "BO_ 1 M: 64 Vector__XXX\n SG_ Crc : 496|16@1+ (1,0) [0|65535] \"\" Vector__XXX\n", "test.dbc");
  const Protection protection{.crc = SignalCodec(*database.find("M")->find("Crc")), .polynomial = Crc::crc16};
  Frame frame{.id = 0x1A5, .kind = FrameKind::fd, .length = 64};
  std::iota(frame.data.begin(), frame.data.end(), std::uint8_t{0x31});
  E2eProtector(protection).seal(frame);
  E2eChecker checker(protection, 64, false);
  ASSERT_FALSE(checker.check(frame));
  const auto flip = [&](unsigned bit) { frame.data[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8); };
  for (unsigned first = 0; first < 512; ++first) {
    flip(first);
    for (unsigned second = first + 1; second < 512; ++second) {
      flip(second);
      ASSERT_EQ(checker.check(frame), Rejection::wrong_crc) << first << ' ' << second;
      flip(second);
    }
    flip(first);
  }
}

TEST(DataIdOfTheCrc, IsTwoBytesOfAStandardIdentifier) {
  expect_covered(frame_with(0x6A5, false), {.kind = DataId::Kind::identifier}, {0xA5, 0x06});
}

TEST(DataIdOfTheCrc, IsFourBytesOfAnExtendedIdentifier) {
  expect_covered(frame_with(0x1ABCDEF5, true), {.kind = DataId::Kind::identifier}, {0xF5, 0xDE, 0xBC, 0x1A});
}

TEST(DataIdOfTheCrc, IsTwoBytesOfANumberWhateverTheIdentifier) {
  for (const bool extended : {false, true})
    expect_covered(frame_with(0x6A5, extended), {.kind = DataId::Kind::number, .number = 0x10A1},
                   {0xA1, 0x10});
}

TEST(DataIdOfTheCrc, IsNotCoveredWhereThereIsNone) {
  for (const bool extended : {false, true})
    expect_covered(frame_with(0x6A5, extended), {.kind = DataId::Kind::none, .number = 0x10A1}, {});
}

TEST(DataIdOfTheCrc, TellsTwoExtendedMessagesApartWhoseIdentifiersDifferInOneByte) {
  const Protection protection{.crc = byte_at(7)};
  Frame sent = frame_with(0x1ABCDEF5, true);
  E2eProtector(protection).seal(sent);
  for (unsigned byte = 0; byte < 4; ++byte) {
    Frame other = sent;
    other.id ^= 1U << 8U * byte;
    E2eChecker receiver(protection, 8, true);
    EXPECT_EQ(receiver.check(other), Rejection::wrong_crc) << "byte " << byte;
  }
}

TEST(CrcByte, MayBeAnyByteOfThePayload) {
  for (std::uint8_t index = 0; index < 8; ++index) {
    Frame frame = frame_with(0x6A5, false);
    E2eProtector({.crc = byte_at(index)}).seal(frame);
    Bytes covered{0xA5, 0x06};
    for (std::uint8_t other = 0; other < 8; ++other)
      if (other != index) covered.push_back(static_cast<std::uint8_t>(0x31 + other));
    EXPECT_EQ(frame.data[index], shifted_crc(covered, 0x1D)) << "byte " << int{index};
  }
}

}  // namespace
}  // namespace hystcan::can::data_id_test
