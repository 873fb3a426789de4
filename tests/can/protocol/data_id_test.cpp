// The bytes that the CRC of a message covers before its payload, compared with a CRC computed one bit at a
// time.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "base/words.h"
#include "can/dbc/database.h"
#include "can/protocol/e2e.h"
#include "tests/support/shows.h"

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

/// A signal of whole bytes in an eight-byte message.
SignalCodec bytes_at(unsigned index, unsigned count) {
  const Database database =
      parse_dbc(fmt::format("BO_ 1 M: 8 Vector__XXX\n SG_ S : {}|{}@1+ (1,0) [0|0] \"\" Vector__XXX\n",
                            8 * index, 8 * count),
                "test.dbc");
  return SignalCodec(*database.find("M")->find("S"));
}
SignalCodec byte_at(unsigned index) { return bytes_at(index, 1); }

constexpr Frame frame_with(std::uint32_t id, bool extended) {
  Frame frame{.id = id, .extended = extended, .length = 8};
  std::iota(frame.data.begin(), frame.data.begin() + 8, std::uint8_t{0x31});
  return frame;
}

/// Expects that the CRC in the last byte of this frame equals the CRC of these bytes and the first seven of
/// the payload.
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

/// Counts the pairs of bits in a frame of this length, CRC included, that leave it valid if both are wrong.
unsigned missed_pairs(Crc polynomial, std::uint8_t length) {
  const Protection protection{.crc = bytes_at(0, bytes_of(polynomial)), .polynomial = polynomial};
  Frame frame{.id = 0x1A5, .kind = FrameKind::fd, .length = length};
  std::iota(frame.data.begin(), frame.data.end(), std::uint8_t{0x31});
  E2eProtector(protection).seal(frame);
  const auto flip = [&](unsigned bit) { frame.data[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8); };
  const auto stated = [&] {
    return bytes_of(polynomial) == 2 ? frame.data[0] | frame.data[1] << 8 : int{frame.data[0]};
  };
  unsigned missed = 0;
  for (unsigned first = 0; first < 8U * length; ++first) {
    flip(first);
    for (unsigned second = first + 1; second < 8U * length; ++second) {
      flip(second);
      if (stated() == protection.crc_of(frame)) ++missed;
      flip(second);
    }
    flip(first);
  }
  return missed;
}

TEST(MostBytesGuarded, IsTheLengthWithDetectionOfAnyTwoWrongBits) {
  shows("S-082");
  for (const Crc crc : {Crc::sae_j1850, Crc::autosar_8h2f}) {
    const auto longest = static_cast<std::uint8_t>(most_bytes_guarded(crc) + 1);
    EXPECT_EQ(missed_pairs(crc, longest), 0u) << word_of(crc);
    EXPECT_GT(missed_pairs(crc, longest + 1), 0u) << word_of(crc);
  }
  EXPECT_EQ(missed_pairs(Crc::crc16, 64), 0u);
}

TEST(DataIdOfTheCrc, IsTwoBytesOfAStandardIdentifier) {
  expect_covered(frame_with(0x6A5, false), {.kind = DataId::Kind::identifier}, {0xA5, 0x06});
}

TEST(DataIdOfTheCrc, IsFourBytesOfAnExtendedIdentifier) {
  expect_covered(frame_with(0x1ABCDEF5, true), {.kind = DataId::Kind::identifier}, {0xF5, 0xDE, 0xBC, 0x1A});
}

TEST(DataIdOfTheCrc, IsTwoBytesOfAConfiguredNumber) {
  for (const bool extended : {false, true})
    expect_covered(frame_with(0x6A5, extended), {.kind = DataId::Kind::number, .number = 0x10A1},
                   {0xA1, 0x10});
}

TEST(DataIdOfTheCrc, IsNotCoveredIfThereIsNone) {
  for (const bool extended : {false, true})
    expect_covered(frame_with(0x6A5, extended), {.kind = DataId::Kind::none, .number = 0x10A1}, {});
}

TEST(DataIdOfTheCrc, DistinguishesExtendedIdentifiersByEachByte) {
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
