#include "can/dbc/message_decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <string>

namespace hystcan::can::message_decoder_test {
namespace {

Frame frame_of(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  Frame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(bytes.size());
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}

/// The decoded signals in their order, for example "A=1 B=2".
std::string decoded(const Database& database, const Frame& frame) {
  std::string text;
  for (const DecodedSignal& each : decode_signals(*message_of(database, frame), frame)) {
    text += (text.empty() ? "" : " ") + each.signal->name + '=' + std::to_string(each.raw);
  }
  return text;
}

TEST(MessageOf, DistinguishesStandardFromExtendedIdentifiers) {
  const Database database = parse_dbc("BO_ 1 A: 1 X\nBO_ 2147483649 B: 1 X\n", "lab.dbc");
  Frame frame = frame_of(1, {0});
  EXPECT_EQ(message_of(database, frame)->name, "A");
  frame.extended = true;
  EXPECT_EQ(message_of(database, frame)->name, "B");
  frame.id = 2;
  EXPECT_EQ(message_of(database, frame), nullptr);
  frame = frame_of(1, {0});
  frame.kind = FrameKind::error;
  EXPECT_EQ(message_of(database, frame), nullptr);
}

TEST(DecodeSignals, GivesRawPhysicalAndName) {
  const Database database = parse_dbc(
      "BO_ 1 A: 8 X\n SG_ Level : 7|16@0- (0.5,10) [0|0] \"V\" X\n SG_ State : 16|8@1+ (1,0) [0|0] \"\" X\n"
      "VAL_ 1 State 3 \"fault\" ;\n",
      "lab.dbc");
  const Frame frame = frame_of(1, {0xFF, 0xFE, 0x03, 0, 0, 0, 0, 0});
  const auto signals = decode_signals(*message_of(database, frame), frame);
  ASSERT_EQ(signals.size(), 2U);
  EXPECT_EQ(signals[0].raw, -2);
  EXPECT_EQ(signals[0].physical, 9.0);
  EXPECT_EQ(signals[0].name, "");
  EXPECT_EQ(signals[1].name, "fault");
}

TEST(DecodeSignals, GivesTheUnchangedBitsOfAFloat) {
  const Database database =
      parse_dbc("BO_ 1 A: 8 X\n SG_ F : 0|32@1- (1,0) [0|0] \"\" X\nSIG_VALTYPE_ 1 F : 1;\n", "lab.dbc");
  const Frame frame = frame_of(1, {0, 0, 0x80, 0xBF, 0, 0, 0, 0});
  const auto signals = decode_signals(*message_of(database, frame), frame);
  ASSERT_EQ(signals.size(), 1U);
  EXPECT_EQ(signals[0].raw, 0xBF800000);
  EXPECT_EQ(signals[0].physical, -1.0);
}

TEST(DecodeSignals, LeavesOutSignalsBeyondThePayload) {
  const Database database = parse_dbc(
      "BO_ 1 A: 1785 X\n SG_ P : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Q : 56|9@1+ (1,0) [0|0] \"\" X\n"
      " SG_ R : 14272|8@1+ (1,0) [0|0] \"\" X\n SG_ Wide : 0|65@1+ (1,0) [0|0] \"\" X\n",
      "lab.dbc");
  EXPECT_EQ(decoded(database, frame_of(1, {1, 2, 3, 4, 5, 6, 7, 8})), "P=1");
  EXPECT_EQ(decoded(database, frame_of(1, {1, 2, 3, 4, 5, 6, 7, 8, 1})), "P=1 Q=264");
  EXPECT_EQ(decoded(database, frame_of(1, {})), "");
  Frame remote = frame_of(1, {1});
  remote.kind = FrameKind::remote;
  EXPECT_EQ(decoded(database, remote), "");
}

TEST(DecodeSignals, ResolvesSimpleMultiplexing) {
  const Database database = parse_dbc(
      "BO_ 1 A: 3 X\n SG_ A0 m0 : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ Mode M : 0|8@1- (1,0) [0|0] \"\" X\n"
      " SG_ A1 m1 : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ A255 m255 : 8|8@1+ (1,0) [0|0] \"\" X\n"
      " SG_ Always : 16|8@1+ (1,0) [0|0] \"\" X\nBO_ 2 B: 1 X\n SG_ Alone m7 : 0|8@1+ (1,0) [0|0] \"\" X\n",
      "lab.dbc");
  EXPECT_EQ(decoded(database, frame_of(1, {0, 5, 9})), "A0=5 Mode=0 Always=9");
  EXPECT_EQ(decoded(database, frame_of(1, {1, 5, 9})), "Mode=1 A1=5 Always=9");
  EXPECT_EQ(decoded(database, frame_of(1, {2, 5, 9})), "Mode=2 Always=9");
  EXPECT_EQ(decoded(database, frame_of(1, {255, 5, 9})), "Mode=-1 A255=5 Always=9")
      << "the bits of the switch decide";
  EXPECT_EQ(decoded(database, frame_of(2, {5})), "Alone=5") << "without a switch it is always present";
}

constexpr const char* extended = R"(BO_ 1 A: 5 X
 SG_ Root M : 0|8@1+ (1,0) [0|0] "" X
 SG_ Sub m2M : 8|8@1+ (1,0) [0|0] "" X
 SG_ Other M : 16|8@1+ (1,0) [0|0] "" X
 SG_ Leaf m1 : 24|8@1+ (1,0) [0|0] "" X
 SG_ Twig m5 : 32|8@1+ (1,0) [0|0] "" X
SG_MUL_VAL_ 1 Sub Root 2-4, 9-9;
SG_MUL_VAL_ 1 Leaf Sub 1-1;
SG_MUL_VAL_ 1 Twig Other 5-5,7-4294967295;
)";

TEST(DecodeSignals, ResolvesExtendedMultiplexing) {
  const Database database = parse_dbc(extended, "lab.dbc");
  EXPECT_EQ(decoded(database, frame_of(1, {3, 1, 0, 8, 9})), "Root=3 Sub=1 Other=0 Leaf=8");
  EXPECT_EQ(decoded(database, frame_of(1, {9, 2, 5, 8, 9})), "Root=9 Sub=2 Other=5 Twig=9");
  EXPECT_EQ(decoded(database, frame_of(1, {5, 1, 6, 8, 9})), "Root=5 Other=6")
      << "Leaf needs Sub, which is absent";
  EXPECT_EQ(decoded(database, frame_of(1, {5, 1, 200, 8, 9})), "Root=5 Other=200 Twig=9");
}

TEST(DecodeSignals, FindsNoSignalInARingOfSwitches) {
  const Database database = parse_dbc(
      "BO_ 1 A: 2 X\n SG_ P m0M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Q m0M : 8|8@1+ (1,0) [0|0] \"\" X\n"
      "SG_MUL_VAL_ 1 P Q 0-0;\nSG_MUL_VAL_ 1 Q P 0-0;\n",
      "lab.dbc");
  EXPECT_EQ(decoded(database, frame_of(1, {0, 0})), "");
}

TEST(DecodeSignals, DistinguishesSignalsOfTheSameNameByTheirSwitch) {
  const Database database = parse_dbc(
      "BO_ 1 A: 3 X\n SG_ M M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ S m0 : 8|8@1+ (1,0) [0|0] \"\" X\n"
      " SG_ S m1 : 16|8@1+ (1,0) [0|0] \"\" X\nSG_MUL_VAL_ 1 S M 0-1;\n",
      "lab.dbc");
  EXPECT_EQ(decoded(database, frame_of(1, {0, 5, 6})), "M=0 S=5");
  EXPECT_EQ(decoded(database, frame_of(1, {1, 5, 6})), "M=1 S=6");
}

}  // namespace
}  // namespace hystcan::can::message_decoder_test
