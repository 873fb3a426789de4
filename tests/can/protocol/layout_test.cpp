// The lab's own frames: maps names to roles, compiles them and encodes frames.
#include "can/protocol/layout.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <string_view>

#include "can/frame_bits.h"
#include "can/log/candump.h"
#include "can/protocol/protocol.h"
#include "tests/support/shows.h"

namespace hystcan::can::layout_test {
namespace {

std::vector<std::uint8_t> bytes_of(const Frame& frame) {
  return {frame.payload().begin(), frame.payload().end()};
}

Database lab() { return load_dbc(HYSTCAN_SOURCE_DIR "/config/lab_amplifier.dbc"); }

MessageMap amp_set() {
  return {.message = "AmpSet",
          .signals = {{"setpoint", "Volt"}, {"enable", "On"}, {"clear_fault", "Rst"}},
          .integrity = Integrity::counter_crc,
          .counter = "Cnt",
          .crc = "Crc",
          .polynomial = Crc::autosar_8h2f,
          .data_id = {.kind = DataId::Kind::number, .number = 0x10A1}};
}

TEST(Crc16, GivesTheCatalogueCheckValue) {
  const std::string digits = "123456789";
  EXPECT_EQ(crc16(std::vector<std::uint8_t>(digits.begin(), digits.end())), 0x29B1);
}

TEST(Crc8H2F, GivesTheCatalogueCheckValue) {
  const std::string_view digits = "123456789";
  EXPECT_EQ(crc8_8h2f(std::vector<std::uint8_t>(digits.begin(), digits.end())), 0xDF);
}

// The lab's command that docs/protocol/own_frames.md annotates:
//   4F      Crc   CRC-8H2F over A1 10 (data id 0x10A1), 13 3F 2D
//   13      Cnt   3, low nibble; On, bit 4
//   3F 2D   Volt  12.346 V = 12346 mV = 2 * 16173 - 20000, 16173 = 0x3F2D, most significant byte first
TEST(Layout, EncodesTheLabCommandOfTheDocumentByteForByte) {
  const Database database = lab();
  Encoder<AmpCommand> encode(Layout<AmpCommand>(*database.find("AmpSet"), amp_set(), "V"));
  std::optional<Frame> frame;
  for (int i = 0; i < 4; ++i) frame = encode({.setpoint = 12.346, .enable = true});  // counters 0, 1, 2, 3
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->id, 0x18EF1001u);
  EXPECT_TRUE(frame->extended);
  EXPECT_EQ(bytes_of(*frame), (std::vector<std::uint8_t>{0x4F, 0x13, 0x3F, 0x2D}));

  Decoder<AmpCommand> decode(Layout<AmpCommand>(*database.find("AmpSet"), amp_set(), "V"));
  const auto command = decode(*frame);
  ASSERT_TRUE(command);
  EXPECT_DOUBLE_EQ(command->setpoint, 12.346);
  EXPECT_TRUE(command->enable);
  EXPECT_FALSE(command->clear_fault);
  frame->data[3] ^= 1;
  EXPECT_FALSE(decode(*frame));
  EXPECT_EQ(decode.checker().rejected(Rejection::wrong_crc), 1u);
}

TEST(Layout, WritesTwoAxesOneAfterTheOtherIntoOneFrame) {
  const auto signal = [](const char* name, std::uint32_t start_bit) {
    Signal made;
    made.name = name;
    made.start_bit = start_bit;
    made.length = 16;
    return made;
  };
  Message message;
  message.id = 0x201;
  message.name = "Both";
  message.length = 12;
  message.signals = {signal("Crc", 0), signal("Cnt", 16), signal("SetX", 32), signal("SetY", 48)};
  const auto layout = [&](const char* set) {
    return Layout<AmpCommand>(
        message,
        {.message = "Both", .signals = {{"setpoint", set}}, .counter = "Cnt", .polynomial = Crc::crc16}, "");
  };
  const Layout<AmpCommand> x = layout("SetX");
  const Layout<AmpCommand> y = layout("SetY");
  Frame frame = x.frame();
  EXPECT_TRUE(x.put({.setpoint = 258.0}, frame));
  EXPECT_TRUE(y.put({.setpoint = 3.0}, frame));
  E2eProtector(x.protection()).seal(frame);
  EXPECT_FALSE(y.checker().check(frame));
  EXPECT_EQ(x.decode(frame).setpoint, 258.0);
  EXPECT_EQ(y.decode(frame).setpoint, 3.0);
  EXPECT_FALSE(y.put({.setpoint = 65536.0}, frame));
  EXPECT_EQ(x.decode(frame).setpoint, 258.0) << "what y cannot represent leaves x";
}

/// The sample of two axes that docs/protocol/own_frames.md annotates.
TEST(Layout, ReadsTheFdSampleOfTheDocumentForEachOfItsAxes) {
  const Database database = parse_dbc(
      "BO_ 449 Positions: 12 Vector__XXX\n SG_ Crc : 0|16@1+ (1,0) [0|65535] \"\" Vector__XXX\n"
      " SG_ Cnt : 16|8@1+ (1,0) [0|255] \"\" Vector__XXX\n SG_ Sync : 24|8@1+ (1,0) [0|240] \"\" Vector__XXX\n"
      " SG_ X : 32|32@1- (1e-6,0) [0|0] \"um\" Vector__XXX\n SG_ Y : 64|32@1- (1e-6,0) [0|0] \"um\" Vector__XXX\n",
      "test.dbc");
  const Message& message = *database.find("Positions");
  const auto layout_of = [&](const char* axis) {
    const MessageMap map{.message = "Positions",
                         .signals = {{"position", axis}, {"sync_counter", "Sync"}},
                         .counter = "Cnt",
                         .crc = "Crc",
                         .polynomial = usual_crc(message.length)};
    return Layout<SensorSample>(message, map, "V");
  };
  Frame frame = *layout_of("X").encode({.position_um = 0.123456, .sync_counter = 7});
  ASSERT_TRUE(SignalCodec(*message.find("Y")).pack(-2.5, frame.payload()));
  E2eProtector protector(layout_of("X").protection());
  for (int i = 0; i < 6; ++i) protector.seal(frame);  // counters 0 to 5
  EXPECT_EQ(candump_frame(frame), "1C1##147DA050740E2010060DAD9FF");
  for (const auto& [axis, position_um] : {std::pair("X", 0.123456), std::pair("Y", -2.5)}) {
    const auto sample = Decoder<SensorSample>(layout_of(axis))(frame);
    ASSERT_TRUE(sample) << axis;
    EXPECT_DOUBLE_EQ(sample->position_um, position_um);
    EXPECT_EQ(sample->sync_counter, 7);
  }
  const FrameBits bits = frame_bits(frame);
  EXPECT_EQ(bits.head, 18u);
  EXPECT_EQ(bits.data, 137u);
  EXPECT_EQ(bits.tail, 12u);
  EXPECT_EQ(transmission_time(bits.all(), {1'000'000, 5'000'000}), std::chrono::nanoseconds(57'400));
}

TEST(Layout, RefusesAValueOutsideTheSignal) {
  shows("S-074");
  const Database database = lab();
  const Layout<AmpCommand> layout(*database.find("AmpSet"), amp_set(), "V");
  EXPECT_TRUE(layout.encode({.setpoint = 111.07}));
  EXPECT_FALSE(layout.encode({.setpoint = 111.08}));
  EXPECT_FALSE(layout.encode({.setpoint = -20.01}));
}

TEST(Layout, RefusesAUnitThatDoesNotConvert) {
  const Database database = lab();
  EXPECT_THROW(Layout<AmpCommand>(*database.find("AmpSet"), amp_set(), "A"), std::invalid_argument);
}

TEST(Layout, ReadsARoleWithoutASignalAsItsAbsentValue) {
  const Database database = lab();
  MessageMap map = amp_set();
  map.signals.erase("enable");
  Encoder<AmpCommand> encode(Layout<AmpCommand>(*database.find("AmpSet"), map, "V"));
  Decoder<AmpCommand> decode(Layout<AmpCommand>(*database.find("AmpSet"), map, "V", {.enable = true}));
  const auto frame = encode({.setpoint = 1.0, .enable = false});
  ASSERT_TRUE(frame);
  EXPECT_TRUE(decode(*frame)->enable);
}

/// The setpoint has 16 to 32 bits in either byte order, any position, any convertible unit, and a message
/// with or without counter and CRC. The decoded value equals the encoded value within half a resolution.
TEST(Layout, DecodesWhatItEncodesForAnySignalDefinition) {
  const bool holds = rc::check([] {
    const auto length = *rc::gen::inRange<std::uint16_t>(16, 33);
    const bool big = *rc::gen::arbitrary<bool>();
    const auto unit = *rc::gen::elementOf(std::vector<std::string>{"nV", "uV", "mV", "V", "kV"});
    const double scale = *rc::gen::elementOf(std::vector<double>{0.001, 0.25, 1.0, 2.0});
    const auto message_length = *rc::gen::elementOf(std::vector<std::uint8_t>{8, 12, 20, 64});
    const auto first_byte =
        *rc::gen::inRange<std::uint16_t>(2, static_cast<std::uint16_t>(message_length - 4));
    const auto integrity =
        *rc::gen::elementOf(std::vector{Integrity::none, Integrity::counter, Integrity::counter_crc});
    const auto signal = [](const char* name, std::size_t start_bit, std::uint16_t bits) {
      Signal made;
      made.name = name;
      made.start_bit = static_cast<std::uint32_t>(start_bit);
      made.length = bits;
      return made;
    };
    Signal set = signal("Set", 8U * first_byte + (big ? 7 : 0), length);
    set.byte_order = big ? ByteOrder::big_endian : ByteOrder::little_endian;
    set.is_signed = true;
    set.scale = scale;
    set.unit = unit;
    Message message;
    message.id = 0x18FF0000;
    message.extended = true;
    message.name = "M";
    message.length = message_length;
    message.signals = {set, signal("Crc", 0, 8), signal("Cnt", 8, 6)};
    const MessageMap map{.message = "M",
                         .signals = {{"setpoint", "Set"}},
                         .integrity = integrity,
                         .counter = "Cnt",
                         .crc = "Crc",
                         .polynomial = *rc::gen::elementOf(std::vector{Crc::sae_j1850, Crc::autosar_8h2f}),
                         .data_id = {.kind = *rc::gen::elementOf(std::vector{
                                         DataId::Kind::identifier, DataId::Kind::number, DataId::Kind::none}),
                                     .number = *rc::gen::arbitrary<std::uint16_t>()}};
    Encoder<AmpCommand> encode(Layout<AmpCommand>(message, map, "V"));
    Decoder<AmpCommand> decode(Layout<AmpCommand>(message, map, "V"));
    const DecimalStep step = *decimal_step(unit, "V");
    const double resolution = step.to_ours(scale);
    const double largest = resolution * (std::ldexp(1.0, length - 1) - 1);
    const double setpoint = largest * *rc::gen::inRange(-1000, 1001) / 1000.0;
    for (int i = 0; i < 3; ++i) {
      const auto frame = encode({.setpoint = setpoint});
      RC_ASSERT(frame.has_value());
      RC_ASSERT(frame->kind == (message_length > 8 ? FrameKind::fd : FrameKind::data));
      const auto command = decode(*frame);
      RC_ASSERT(command.has_value());
      RC_ASSERT(std::abs(command->setpoint - setpoint) <= 0.5000001 * resolution);
      const auto again = encode({.setpoint = command->setpoint});  // a decoded value no longer changes
      RC_ASSERT(again.has_value());
      RC_ASSERT(decode(*again)->setpoint == command->setpoint);
    }
  });
  EXPECT_TRUE(holds);
}

TEST(DecimalStep, ConvertsExactly) {
  EXPECT_EQ(decimal_step("mV", "V")->to_ours(12346.0), 12.346);
  EXPECT_EQ(decimal_step("mV", "V")->to_theirs(0.5), 500.0);
  EXPECT_EQ(decimal_step("nm", "um")->to_ours(3.0), 0.003);
  EXPECT_EQ(decimal_step("mm", "um")->to_ours(0.125), 125.0);
  EXPECT_EQ(decimal_step("\xC2\xB5m", "um")->to_ours(7.1), 7.1);
  EXPECT_EQ(decimal_step("mA", "A")->to_ours(1.0), 0.001);
  EXPECT_EQ(decimal_step("furlong", "furlong")->to_ours(2.0), 2.0);
}

TEST(DecimalStep, IsEmptyIfTheUnitsDoNotConvert) {
  for (const auto& [theirs, ours] :
       {std::pair{"mV", "A"}, std::pair{"V", "um"}, std::pair{"", "V"}, std::pair{"%", "V"},
        std::pair{"xV", "V"}, std::pair{"m", "V"}, std::pair{"V", ""}})
    EXPECT_FALSE(decimal_step(theirs, ours)) << theirs << " to " << ours;
}

TEST(StateValues, ReadsAndSendsTheLabsRawValues) {
  const StateValues table{.off = {0}, .ready = {16}, .enabled = {32}, .fault = {64, 65}};
  EXPECT_EQ(table.state(16), AmpState::ready);
  EXPECT_EQ(table.state(65), AmpState::fault);
  EXPECT_EQ(table.state(7), AmpState::off);
  EXPECT_EQ(table.raw(AmpState::fault), 64);
}

TEST(StateValues, ReadsTheMoreSevereStateIfOneValueMeansTwo) {
  const StateValues table{.off = {0}, .ready = {1}, .enabled = {1}, .fault = {}};
  EXPECT_EQ(table.state(1), AmpState::enabled);
  EXPECT_EQ(table.raw(AmpState::fault), 0);
}

}  // namespace
}  // namespace hystcan::can::layout_test
