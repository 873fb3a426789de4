#include "can/protocol/e2e.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <string_view>
#include <vector>

#include "can/dbc/database.h"
#include "tests/support/shows.h"

namespace hystcan::can::e2e_test {
namespace {

/// CRC-8/SAE-J1850 one bit at a time, like a shift register.
std::uint8_t bitwise_crc(const std::vector<std::uint8_t>& bytes) {
  unsigned reg = 0xFF;
  for (const unsigned byte : bytes) {
    for (int bit = 7; bit >= 0; --bit) {
      const unsigned feedback = (reg >> 7U ^ byte >> bit) & 1U;
      reg = (reg << 1U & 0xFFU) ^ (feedback != 0 ? 0x1DU : 0U);
    }
  }
  return static_cast<std::uint8_t>(reg ^ 0xFFU);
}

const Database& shipped() {
  static const Database database = load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  return database;
}

SignalCodec codec(const char* signal) { return SignalCodec(*shipped().find("XAmpCommand")->find(signal)); }
Protection protection() { return {codec("Counter"), codec("Crc")}; }
E2eChecker checker() { return {protection(), 8, false}; }

Frame sealed_frame(unsigned counter) {
  Frame frame{.id = 0x201, .length = 8};
  E2eProtector protector(protection());
  for (unsigned i = 0; i <= counter; ++i) protector.seal(frame);
  return frame;
}

TEST(Crc8J1850, GivesTheCatalogueCheckValue) {
  shows("S-077");
  const std::string_view digits = "123456789";
  EXPECT_EQ(crc8_j1850(std::vector<std::uint8_t>(digits.begin(), digits.end())), 0x4B);
  EXPECT_EQ(crc8_j1850({}), 0x00);
}

TEST(Crc8J1850, AgreesWithABitwiseShiftRegister) {
  shows("S-077");
  EXPECT_TRUE(rc::check(
      [](const std::vector<std::uint8_t>& bytes) { RC_ASSERT(crc8_j1850(bytes) == bitwise_crc(bytes)); }));
}

// The frame that docs/protocol/frames.md annotates:
//   4E 61 BC 00   Setpoint     12.345678 V, raw 12345678 = 0x00BC614E
//   01            Enable       bit 0
//   07            SyncCounter  7
//   03            Counter      3, low nibble
//   D9            Crc          over 01 02 4E 61 BC 00 01 07 03
TEST(E2eProtector, MakesTheAmpCommandOfTheDocumentByteForByte) {
  shows("S-075");
  Frame frame{.id = 0x201, .length = 8};
  ASSERT_TRUE(codec("Setpoint").pack(12.345678, frame.payload()));
  ASSERT_TRUE(codec("Enable").pack(1.0, frame.payload()));
  ASSERT_TRUE(codec("SyncCounter").pack(7.0, frame.payload()));
  E2eProtector protector(protection());
  for (int i = 0; i < 4; ++i) protector.seal(frame);  // counters 0, 1, 2, 3

  const std::vector<std::uint8_t> expected = {0x4E, 0x61, 0xBC, 0x00, 0x01, 0x07, 0x03, 0xD9};
  EXPECT_EQ(std::vector<std::uint8_t>(frame.payload().begin(), frame.payload().end()), expected);
  EXPECT_EQ(bitwise_crc({0x01, 0x02, 0x4E, 0x61, 0xBC, 0x00, 0x01, 0x07, 0x03}), 0xD9);
  EXPECT_EQ(checker().check(frame), std::nullopt);
}

TEST(E2eProtector, CountsToFifteenAndStartsAgain) {
  shows("S-076");
  Frame frame{.id = 0x201, .length = 8};
  E2eProtector protector(protection());
  for (unsigned i = 0; i < 1000; ++i) {
    protector.seal(frame);
    ASSERT_EQ(frame.data[6], i % 16);
  }
}

TEST(E2eChecker, AcceptsAnUnbrokenSequence) {
  E2eChecker receiver = checker();
  Frame frame{.id = 0x201, .length = 8};
  E2eProtector protector(protection());
  for (int i = 0; i < 100; ++i) {
    protector.seal(frame);
    ASSERT_EQ(receiver.check(frame), std::nullopt);
  }
  EXPECT_EQ(receiver.accepted(), 100U);
}

TEST(E2eChecker, CountsEachCauseSeparately) {
  shows("S-078");
  const Frame good = sealed_frame(5);
  const auto spoilt = [&](auto spoil) {
    Frame frame = good;
    spoil(frame);
    return frame;
  };
  E2eChecker receiver = checker();
  using enum Rejection;
  EXPECT_EQ(receiver.check(spoilt([](Frame& f) { f.kind = FrameKind::remote; })), wrong_kind);
  EXPECT_EQ(receiver.check(spoilt([](Frame& f) { f.kind = FrameKind::fd; })), wrong_kind);
  EXPECT_EQ(receiver.check(spoilt([](Frame& f) { f.kind = FrameKind::error; })), wrong_kind);
  EXPECT_EQ(receiver.check(spoilt([](Frame& f) { f.extended = true; })), extended_id);
  EXPECT_EQ(receiver.check(spoilt([](Frame& f) { f.length = 7; })), wrong_length);
  EXPECT_EQ(receiver.check(spoilt([](Frame& f) { f.length = 0; })), wrong_length);
  EXPECT_EQ(receiver.check(spoilt([](Frame& f) { f.data[0] ^= 1; })), wrong_crc);
  EXPECT_EQ(receiver.check(spoilt([](Frame& f) { f.id = 0x203; })), wrong_crc);
  EXPECT_EQ(receiver.check(good), std::nullopt);
  EXPECT_EQ(receiver.check(good), repeated_counter);
  const std::array<std::uint64_t, rejection_count> expected = {3, 1, 2, 2, 1};
  for (std::size_t i = 0; i < rejection_count; ++i)
    EXPECT_EQ(receiver.rejected(static_cast<Rejection>(i)), expected[i]);
  EXPECT_EQ(receiver.accepted(), 1U);
}

TEST(E2eChecker, RejectsEverySingleBitErrorAndEveryBurstOfUpToEightBits) {
  const Frame good = sealed_frame(3);
  for (unsigned first = 0; first < 64; ++first) {
    for (unsigned pattern = 1; pattern < 256; pattern += 2) {  // the burst starts at `first`
      Frame frame = good;
      for (unsigned bit = 0; bit < 8 && first + bit < 64; ++bit) {
        const unsigned place = first + bit;  // in wire order: the most significant bit of a byte first
        if ((pattern >> bit & 1U) != 0)
          frame.data[place / 8] ^= static_cast<std::uint8_t>(0x80U >> place % 8);
      }
      E2eChecker receiver = checker();
      ASSERT_EQ(receiver.check(frame), Rejection::wrong_crc) << first << ' ' << pattern;
    }
  }
}

TEST(E2eChecker, AcceptsAnyCounterAfterARestart) {
  shows("S-080");
  E2eChecker receiver = checker();
  const Frame frame = sealed_frame(3);
  EXPECT_EQ(receiver.check(frame), std::nullopt);
  receiver.restart();
  EXPECT_EQ(receiver.check(frame), std::nullopt);
}

TEST(E2eChecker, IgnoresTheCounterOfARejectedFrame) {
  shows("S-079");
  E2eChecker receiver = checker();
  const Frame frame = sealed_frame(3);
  Frame broken = frame;
  broken.data[7] ^= 0x10;
  EXPECT_EQ(receiver.check(broken), Rejection::wrong_crc);
  EXPECT_EQ(receiver.check(frame), std::nullopt);
}

TEST(E2eChecker, RejectsAStandardFrameForAnExtendedMessage) {
  E2eChecker receiver(protection(), 8, true);
  EXPECT_EQ(receiver.check(sealed_frame(0)), Rejection::extended_id);
}

}  // namespace
}  // namespace hystcan::can::e2e_test
