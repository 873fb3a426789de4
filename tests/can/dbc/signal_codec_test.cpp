#include "can/dbc/signal_codec.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace hystcan::can::signal_codec_test {
namespace {

using Payload = std::vector<std::uint8_t>;

Signal signal_at(unsigned start, unsigned length, ByteOrder order, bool is_signed) {
  Signal signal;
  signal.name = "S";
  signal.start_bit = static_cast<std::uint16_t>(start);
  signal.length = static_cast<std::uint16_t>(length);
  signal.byte_order = order;
  signal.is_signed = is_signed;
  return signal;
}

Signal setpoint() {
  Signal signal = signal_at(0, 32, ByteOrder::little_endian, true);
  signal.scale = 1e-6;
  signal.minimum = -1000.0;
  signal.maximum = 1000.0;
  return signal;
}

/// The oracle: the position of bit `n` (0 = least significant) of a signal, found one bit at a time.
struct BitPlace {
  unsigned byte;
  unsigned bit;
};
BitPlace place_of(const Signal& signal, unsigned n) {
  unsigned byte = signal.start_bit / 8U;
  unsigned bit = signal.start_bit % 8U;
  if (signal.byte_order == ByteOrder::little_endian) {
    for (; n > 0; --n) {
      if (++bit == 8) {
        bit = 0;
        ++byte;
      }
    }
    return {byte, bit};
  }
  for (unsigned down = signal.length - 1U - n; down > 0; --down) {
    if (bit-- == 0) {
      bit = 7;
      ++byte;
    }
  }
  return {byte, bit};
}

std::int64_t oracle_unpack(const Signal& signal, const Payload& payload) {
  std::int64_t value = 0;
  for (unsigned n = 0; n < signal.length; ++n) {
    const auto [byte, bit] = place_of(signal, n);
    if ((payload[byte] >> bit & 1) == 0) continue;
    const auto weight = static_cast<std::int64_t>(std::uint64_t{1} << n);
    const bool sign_bit = signal.is_signed && n + 1U == signal.length;
    value = sign_bit ? (n == 63 ? value | weight : value - weight) : value | weight;
  }
  return value;
}

Payload oracle_pack(const Signal& signal, std::int64_t raw, Payload payload) {
  for (unsigned n = 0; n < signal.length; ++n) {
    const auto [byte, bit] = place_of(signal, n);
    const unsigned cleared = payload[byte] & ~(1U << bit);
    payload[byte] = static_cast<std::uint8_t>(cleared | ((static_cast<std::uint64_t>(raw) >> n & 1U) << bit));
  }
  return payload;
}

struct Case {
  Signal signal;
  Payload payload;
};

/// Any signal of 1..64 bits at any place in a payload of 1..64 bytes.
Case any_case() {
  const auto bytes = *rc::gen::inRange<unsigned>(1, 65);
  const auto length = *rc::gen::inRange<unsigned>(1, std::min(64U, 8 * bytes) + 1);
  const auto along_wire = *rc::gen::inRange<unsigned>(0, 8 * bytes - length + 1);
  const auto order = *rc::gen::element(ByteOrder::little_endian, ByteOrder::big_endian);
  const unsigned start =
      order == ByteOrder::little_endian ? along_wire : 8 * (along_wire / 8) + 7 - along_wire % 8;
  return {signal_at(start, length, order, *rc::gen::arbitrary<bool>()),
          *rc::gen::container<Payload>(bytes, rc::gen::arbitrary<std::uint8_t>())};
}

TEST(SignalCodec, UnpacksTheSameBitsAsTheOracle) {
  EXPECT_TRUE(rc::check([] {
    const Case any = any_case();
    RC_ASSERT(SignalCodec(any.signal).unpack_raw(any.payload) == oracle_unpack(any.signal, any.payload));
  }));
}

TEST(SignalCodec, PacksOnlyItsOwnBits) {
  EXPECT_TRUE(rc::check([] {
    const Case any = any_case();
    const auto raw = std::bit_cast<std::int64_t>(*rc::gen::arbitrary<std::uint64_t>() * 0x9E3779B97F4A7C15U);
    Payload packed = any.payload;
    SignalCodec(any.signal).pack_raw(raw, packed);
    RC_ASSERT(packed == oracle_pack(any.signal, raw, any.payload));
  }));
}

TEST(SignalCodec, HandlesEveryLengthAtEveryBitOfEightNineAndSixtyFourBytes) {
  for (const unsigned bytes : {8U, 9U, 64U}) {
    for (const auto order : {ByteOrder::little_endian, ByteOrder::big_endian}) {
      for (unsigned length = 1; length <= 64; ++length) {
        for (unsigned at = 0; at + length <= 8 * bytes; ++at) {
          const unsigned start = order == ByteOrder::little_endian ? at : 8 * (at / 8) + 7 - at % 8;
          const Signal signal = signal_at(start, length, order, at % 2 == 0);
          Payload payload(bytes);
          for (std::size_t i = 0; i < bytes; ++i)
            payload[i] = static_cast<std::uint8_t>(0x9D * (i + 3) + length);
          const SignalCodec codec(signal);
          ASSERT_EQ(codec.unpack_raw(payload), oracle_unpack(signal, payload))
              << length << " bits at " << start;
          const Payload expected = oracle_pack(signal, 0x5A3C96F1E87B2D04, payload);
          codec.pack_raw(0x5A3C96F1E87B2D04, payload);
          ASSERT_EQ(payload, expected) << length << " bits at " << start;
        }
      }
    }
  }
}

TEST(SignalCodec, PlacesLittleEndianAndBigEndianSignalsAsTheFormatDefines) {
  Payload payload(8);
  SignalCodec(signal_at(12, 12, ByteOrder::little_endian, false)).pack_raw(0xABC, payload);
  EXPECT_EQ(payload, (Payload{0x00, 0xC0, 0xAB, 0, 0, 0, 0, 0}));
  payload.assign(8, 0);
  SignalCodec(signal_at(3, 12, ByteOrder::big_endian, false)).pack_raw(0xABC, payload);
  EXPECT_EQ(payload, (Payload{0x0A, 0xBC, 0, 0, 0, 0, 0, 0}));
}

TEST(SignalCodec, RoundsToTheNearestRawValue) {
  const SignalCodec codec(setpoint());
  Payload payload(8);
  ASSERT_TRUE(codec.pack(12.3456784, payload));
  EXPECT_EQ(codec.unpack_raw(payload), 12345678);
  ASSERT_TRUE(codec.pack(12.3456786, payload));
  EXPECT_EQ(codec.unpack_raw(payload), 12345679);
  ASSERT_TRUE(codec.pack(-12.3456786, payload));
  EXPECT_EQ(codec.unpack_raw(payload), -12345679);
}

TEST(SignalCodec, RefusesAValueThatItCannotRepresentAndKeepsThePayload) {
  const double infinity = std::numeric_limits<double>::infinity();
  const SignalCodec limited(setpoint());
  Signal whole = signal_at(4, 8, ByteOrder::little_endian, false);
  const SignalCodec unlimited(whole);
  const Payload before(8, 0xA5);
  Payload payload = before;
  for (const double bad :
       {1000.000001, -1000.000001, 2147.483648, 4294.967296, 1e300, infinity, -infinity, std::nan("")}) {
    EXPECT_FALSE(limited.pack(bad, payload)) << bad;
    EXPECT_EQ(payload, before);
  }
  for (const double bad : {-1.0, -0.001, 255.1, 256.0, std::nan("")}) {
    EXPECT_FALSE(unlimited.pack(bad, payload)) << bad;
    EXPECT_EQ(payload, before);
  }
  EXPECT_TRUE(unlimited.pack(255.0, payload));
  EXPECT_TRUE(limited.pack(1000.0, payload));
}

TEST(SignalCodec, RefusesInfinityEvenIfTheRangeOverflows) {
  Signal wide = signal_at(0, 64, ByteOrder::little_endian, true);
  wide.scale = 1e300;
  Payload payload(8);
  EXPECT_FALSE(SignalCodec(wide).pack(std::numeric_limits<double>::infinity(), payload));
  EXPECT_TRUE(SignalCodec(wide).pack(1e301, payload));
  EXPECT_EQ(SignalCodec(wide).unpack_raw(payload), 10);
}

TEST(SignalCodec, AcceptsBothEndsOfItsRangeAtEveryLength) {
  for (const bool is_signed : {false, true}) {
    for (const double scale : {1.0, 1e-6, -0.25, 0.1}) {
      for (unsigned length = 1; length <= 64; ++length) {
        Signal signal = signal_at(0, length, ByteOrder::little_endian, is_signed);
        signal.scale = scale;
        const SignalCodec codec(signal);
        Payload payload(8);
        ASSERT_TRUE(codec.pack(codec.minimum(), payload)) << length;
        EXPECT_NEAR(codec.unpack(payload), codec.minimum(), 1e-15 * std::abs(codec.minimum()));
        ASSERT_TRUE(codec.pack(codec.maximum(), payload)) << length;
        EXPECT_NEAR(codec.unpack(payload), codec.maximum(), 1e-15 * std::abs(codec.maximum()));
      }
    }
  }
}

TEST(SignalCodec, PacksAnUnpackedValueToTheSameBits) {
  EXPECT_TRUE(rc::check([] {
    Signal signal =
        signal_at(0, *rc::gen::inRange(1U, 49U), ByteOrder::little_endian, *rc::gen::arbitrary<bool>());
    signal.scale = *rc::gen::element(1e-6, 0.1, 0.001, -0.3, 7.0);
    signal.offset = *rc::gen::element(0.0, -40.0, 0.7);
    const SignalCodec codec(signal);
    const auto before = *rc::gen::container<Payload>(8, rc::gen::arbitrary<std::uint8_t>());
    Payload after = before;
    RC_ASSERT(codec.pack(codec.unpack(before), after));
    RC_ASSERT(after == before);
  }));
}

TEST(SignalCodec, ReadsAndWritesIeeeNumbers) {
  Signal single = signal_at(0, 32, ByteOrder::little_endian, true);
  single.value_type = ValueType::float32;
  Payload payload(8);
  ASSERT_TRUE(SignalCodec(single).pack(-1.5, payload));
  EXPECT_EQ(payload, (Payload{0x00, 0x00, 0xC0, 0xBF, 0, 0, 0, 0}));
  EXPECT_EQ(SignalCodec(single).unpack(payload), -1.5);
  EXPECT_FALSE(SignalCodec(single).pack(1e300, payload));
  EXPECT_FALSE(SignalCodec(single).pack(std::nan(""), payload));

  Signal twice = signal_at(7, 64, ByteOrder::big_endian, true);
  twice.value_type = ValueType::float64;
  ASSERT_TRUE(SignalCodec(twice).pack(1.0, payload));
  EXPECT_EQ(payload, (Payload{0x3F, 0xF0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(SignalCodec(twice).unpack(payload), 1.0);
}

TEST(SignalCodec, ReadsUnsigned64BitValuesAbove2To63AndPacksThem) {
  const SignalCodec codec(signal_at(0, 64, ByteOrder::little_endian, false));
  Payload payload(8);
  payload[7] = 0x80;
  EXPECT_EQ(codec.unpack(payload), 9223372036854775808.0);
  payload.assign(8, 0);
  ASSERT_TRUE(codec.pack(13835058055282163712.0, payload)) << "2^63 + 2^62";
  EXPECT_EQ(payload, (Payload{0, 0, 0, 0, 0, 0, 0, 0xC0}));
}

TEST(SignalCodec, NeverPacksWithAScaleOfZero) {
  Signal signal = signal_at(0, 8, ByteOrder::little_endian, false);
  signal.scale = 0.0;
  signal.offset = 5.0;
  Payload payload(8, 0xA5);
  EXPECT_EQ(SignalCodec(signal).unpack(payload), 5.0);
  EXPECT_FALSE(SignalCodec(signal).pack(5.0, payload));
}

TEST(SignalCodec, RefusesASignalWithAnUnsupportedLength) {
  EXPECT_THROW(SignalCodec(signal_at(0, 0, ByteOrder::little_endian, false)), std::invalid_argument);
  EXPECT_THROW(SignalCodec(signal_at(0, 65, ByteOrder::big_endian, false)), std::invalid_argument);
  Signal half = signal_at(0, 16, ByteOrder::little_endian, true);
  half.value_type = ValueType::float32;
  EXPECT_THROW(SignalCodec{half}, std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::can::signal_codec_test
