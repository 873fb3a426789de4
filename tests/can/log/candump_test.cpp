// The log format of candump: literal lines in both directions, strict refusals, and a round trip of any
// frame.
#include "can/log/candump.h"

#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <sstream>

#include "tests/support/refusal.h"

namespace hystcan::can::candump_test {
namespace {

using std::chrono::microseconds;

LoggedFrame only_frame_of(const std::string& text) {
  std::istringstream stream(text);
  CandumpReader reader(stream, "log");
  const auto first = reader.next();
  EXPECT_TRUE(first) << text;
  EXPECT_FALSE(reader.next()) << text;
  return first.value_or(LoggedFrame{});
}

std::string refusal_of(const std::string& text) {
  std::istringstream stream(text);
  CandumpReader reader(stream, "log");
  return support::refusal_of([&] {
    while (reader.next()) continue;
  });
}

TEST(Candump, ReadsAndWritesEveryKindOfFrameAsCandumpDoes) {
  for (const char* line : {
           "(1699876543.123456) can0 123#11223344",
           "(0000000000.000000) vcan0 000#",
           "(1699876543.000001) can0 12345678#1122334455667788",
           "(1699876543.123456) can0 00000123#",
           "(1699876543.123456) can0 123#R",
           "(1699876543.123456) can0 123#R5",
           "(1699876543.123456) can0 1FFFFFFF#R8",
           "(1699876543.123456) can0 123##0",
           "(1699876543.123456) can0 123##7112233445566778899AABBCC",
           "(1699876543.123456) can0 20000004#0008000000006000",
           "(1699876543.123456) can0 123#11 R",
           "(1699876543.123456) can0 123#11 T",
       })
    EXPECT_EQ(candump_line(only_frame_of(line)), line);
}

TEST(Candump, ReadsEveryFieldOfALine) {
  const LoggedFrame logged = only_frame_of("(1699876543.000012) can1 00000201#4E61BC00 T\n");
  EXPECT_EQ(logged.time, microseconds{1'699'876'543'000'012});
  EXPECT_EQ(logged.interface, "can1");
  EXPECT_TRUE(logged.frame.extended);
  EXPECT_EQ(logged.frame.id, 0x201U);
  EXPECT_EQ(logged.frame.kind, FrameKind::data);
  ASSERT_EQ(logged.frame.length, 4);
  EXPECT_EQ(logged.frame.data[1], 0x61);
  EXPECT_EQ(logged.direction, Direction::transmitted);
}

TEST(Candump, ReadsTheClassesOfAnErrorFrameWithoutTheErrorFlag) {
  const LoggedFrame logged = only_frame_of("(1.000000) can0 20000040#0000000000000000");
  EXPECT_EQ(logged.frame.kind, FrameKind::error);
  EXPECT_EQ(logged.frame.id, CAN_ERR_BUSOFF);
  EXPECT_FALSE(logged.frame.extended);
}

TEST(Candump, ReadsAnErrorFrameOfPythonCanOnAnFdBus) {
  const LoggedFrame logged = only_frame_of("(1795852801.200000) can0 20000080##0");
  EXPECT_EQ(logged.frame.kind, FrameKind::error);
  EXPECT_EQ(logged.frame.id, 0x80U);
}

TEST(Candump, LeavesOutALastLineThatACrashHasCut) {
  const std::string whole = "(1.000000) can0 123#1122\n";
  for (const std::string& rest : {std::string("(1.1000"), std::string("(1.100000) can0 123#11"),
                                  "(1.10" + std::string(9, '\0'), std::string(5000, '\0')}) {
    std::istringstream stream(whole + rest);
    CandumpReader reader(stream, "log");
    EXPECT_TRUE(reader.next());
    EXPECT_FALSE(reader.is_cut());
    EXPECT_FALSE(reader.next()) << rest;
    EXPECT_TRUE(reader.is_cut());
  }
}

TEST(Candump, RefusesZerosWithoutAnEnd) {
  EXPECT_NE(refusal_of(std::string(std::size_t{2} << 20U, '\0')).find("the line is too long"),
            std::string::npos);
}

TEST(Candump, NamesTheConverterOfAnotherLog) {
  EXPECT_EQ(refusal_of("date Mon Nov 23 09:00:00.000 am 2026\nbase hex  timestamps absolute\n"),
            "log:1:1: found a log of Vector (ASC), expected a log of candump -L: `asc2log -I FILE -O LOG` "
            "converts it");
  EXPECT_NE(refusal_of(";$FILEVERSION=1.1\n").find("can_logconvert"), std::string::npos);
  EXPECT_NE(refusal_of(std::string("LOGG\x90\0\0\0", 8)).find("can_logconvert"), std::string::npos);
}

TEST(Candump, ReadsBitRateSwitchAndErrorStateOfAnFdFrameAndWritesThemAgain) {
  for (const auto& [line, flags] : {std::pair("(0000000001.000000) can0 123##1AA", +fd_bit_rate_switch),
                                    std::pair("(0000000001.000000) can0 123##2AA", +fd_error_state),
                                    std::pair("(0000000001.000000) can0 12345678##3", 3)}) {
    const LoggedFrame logged = only_frame_of(line);
    EXPECT_EQ(logged.frame.fd_flags, flags);
    EXPECT_EQ(candump_line(logged), line);
  }
}

TEST(Candump, ReadsVariantsThatItDoesNotWrite) {
  EXPECT_EQ(only_frame_of("(1.123456789) can0 123#11").time, microseconds{1'123'456});
  EXPECT_EQ(only_frame_of("(1.000000)   can0 123#11.22.33").frame.length, 3);
  EXPECT_EQ(only_frame_of("(1.000000) can0 7ff#ab\r\n").frame.data[0], 0xAB);
  EXPECT_EQ(only_frame_of("(1.000000) can0 123#1122334455667788_E").frame.length, 8);
  EXPECT_EQ(only_frame_of("# a comment\n\n(1.000000) can0 123#\n").frame.length, 0);
}

TEST(Candump, CountsTheFramesThatCandumpReportsAsDropped) {
  std::istringstream stream(
      "DROPCOUNT: dropped 12 CAN frames on 'can0' socket (total drops 12)\n(1.000000) can0 123#\n"
      "DROPCOUNT: dropped 1 CAN frame on 'can0' socket (total drops 13)\n");
  CandumpReader reader(stream, "log");
  EXPECT_TRUE(reader.next());
  EXPECT_EQ(reader.line(), 2U);
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.dropped(), 13U);
}

TEST(Candump, RefusesALineWithThePlaceAndTheExpectedText) {
  const std::pair<const char*, const char*> cases[] = {
      {"nonsense", "log:1:1: found 'n', expected '(' and the time of a frame"},
      {"(1.000000) can0 123#\n(x\n", "log:2:2: found 'x', expected the time in seconds since 1970"},
      {"(-1.000000) can0 123#", "log:1:2: found '-', expected the time"},
      {"(99999999999999999999.000000) can0 123#", "log:1:2: found '9', expected the time"},
      {"(1.00000) can0 123#", "log:1:4: found '0', expected six digits"},
      {"(1.000000 can0 123#", "log:1:10: found a blank, expected ')'"},
      {"(1.000000)", "log:1:11: found the end of the line, expected a blank"},
      {"(1.000000) can0", "log:1:16: found the end of the line, expected a blank after the interface"},
      {"(1.000000) can0 12#", "log:1:17: found '1', expected an identifier of three or eight"},
      {"(1.000000) can0 800#", "log:1:17: found '8', expected an identifier of 11 bits"},
      {"(1.000000) can0 40000000#", "log:1:17: found '4', expected an identifier of 29 bits"},
      {"(1.000000) can0 123", "log:1:20: found the end of the line, expected '#'"},
      {"(1.000000) can0 123#1", "log:1:22: found the end of the line, expected two hexadecimal digits"},
      {"(1.000000) can0 123#112233445566778899", "log:1:37: found '9', expected at most 8 bytes"},
      {"(1.000000) can0 123#R9", "log:1:22: found '9', expected the length of a remote frame, 0 to 8"},
      {"(1.000000) can0 123##", "log:1:22: found the end of the line, expected the flags"},
      {"(1.000000) can0 20000004#R", "log:1:26: found 'R', expected the data of an error frame"},
      {"(1.000000) can0 123#11_9", "log:1:23: found '_', expected 8 bytes of data before the DLC"},
      {"(1.000000) can0 123#11 X", "log:1:24: found 'X', expected the end of the line"},
      {"(1.000000) can0 123#11\x01", "log:1:23: found byte 0x01, expected hexadecimal digits"},
  };
  for (const auto& [line, expected] : cases)
    EXPECT_TRUE(refusal_of(line).starts_with(expected)) << line << "\n" << refusal_of(line);
}

TEST(Candump, RefusesAnEndlessLineBeforeItFillsTheMemory) {
  EXPECT_TRUE(refusal_of(std::string(1 << 20, 'x')).starts_with("log:1:"))
      << refusal_of(std::string(1 << 20, 'x'));
  EXPECT_NE(refusal_of(std::string(1 << 20, 'x')).find("the line is too long"), std::string::npos);
}

TEST(Candump, DistinguishesADropNoticeFromAnOverflowOfTheController) {
  EXPECT_EQ(candump_frame(drop_notice(0x030201)), "20000004#000100004C010203");
  EXPECT_EQ(drops_reported_by(drop_notice(77)), 77U);
  EXPECT_EQ(drops_reported_by(drop_notice(0xFFFF'FFFF)), 0xFF'FFFFU);
  EXPECT_FALSE(drops_reported_by(only_frame_of("(1.000000) can0 20000004#0001000000000000").frame));
}

LoggedFrame any_frame() {
  LoggedFrame logged;
  logged.time = microseconds{*rc::gen::inRange<std::int64_t>(0, 9'000'000'000'000'000)};
  logged.interface = *rc::gen::element<std::string>("can0", "vcan12", "slcan-3");
  Frame& frame = logged.frame;
  frame.kind = *rc::gen::element(FrameKind::data, FrameKind::remote, FrameKind::fd, FrameKind::error);
  frame.extended = frame.kind != FrameKind::error && *rc::gen::arbitrary<bool>();
  const bool short_id = !frame.extended && frame.kind != FrameKind::error;
  frame.id = *rc::gen::inRange<std::uint32_t>(0, short_id ? 0x800U : 0x2000'0000U);
  frame.length = *rc::gen::inRange<std::uint8_t>(0, frame.kind == FrameKind::fd ? 65 : 9);
  if (frame.kind != FrameKind::remote)
    for (std::uint8_t& byte : frame.payload()) byte = *rc::gen::arbitrary<std::uint8_t>();
  if (frame.kind == FrameKind::fd) logged.frame.fd_flags = *rc::gen::inRange<std::uint8_t>(0, 16);
  logged.direction = *rc::gen::element(Direction::unstated, Direction::received, Direction::transmitted);
  return logged;
}

RC_GTEST_PROP(Candump, ReadsEveryWrittenFrameUnchanged, ()) {
  const LoggedFrame logged = any_frame();
  std::istringstream stream(candump_line(logged) + "\n");
  CandumpReader reader(stream, "log");
  const auto back = reader.next();
  RC_ASSERT(back.has_value());
  RC_ASSERT(*back == logged);
}

}  // namespace
}  // namespace hystcan::can::candump_test
