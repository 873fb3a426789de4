// hystcan decode, and the errors of monitor without a bus.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/app/command_line/cli.h"

namespace hystcan::decode_test {
namespace {

using nlohmann::json;

constexpr const char* small_dbc = R"(VERSION ""
NS_ :
BS_:
BU_: A
BO_ 256 Wide: 8 A
 SG_ Big : 0|64@1+ (1,0) [0|0] "" A
BO_ 257 Muxed: 8 A
 SG_ Which M : 0|8@1+ (1,0) [0|0] "" A
 SG_ One m1 : 8|16@1- (0.1,0) [0|0] "A,B" A
 SG_ Two m2 : 8|16@1+ (2,100) [0|0] "%" A
BO_ 258 Float: 4 A
 SG_ Number : 0|32@1- (1,0) [0|0] "" A
VAL_ 257 Which 1 "first" 2 "second" ;
SIG_VALTYPE_ 258 Number : 1;
)";

class Decode : public Cli {
 protected:
  void SetUp() override { write("small.dbc", small_dbc); }
  /// Runs decode over the log.
  Process run(const std::string& log, std::vector<std::string> options = {}, const char* dbc = "small.dbc") {
    write("a.log", log);
    std::vector<std::string> command{HYSTCAN_PROGRAM, "decode", path("a.log"), "--dbc", path(dbc)};
    command.insert(command.end(), options.begin(), options.end());
    return Process(command);
  }
};

TEST_F(Decode, ShowsMessagesWithValuesUnitsAndNames) {
  Process program = run("(1.500000) can0 101#01FFFF\n(2.000000) can0 101#020A00\n(2.5000000) can0 7FF#AB\n");
  EXPECT_EQ(program.wait(), bad_input) << "seven digits";
  Process sound =
      run("(1.500000) can0 101#01FFFF\n(2.000000) can0 101#020A000000000000\n(2.500000) can0 7FF#AB\n");
  EXPECT_EQ(sound.wait(), done) << sound.err();
  EXPECT_EQ(sound.out(),
            "(1.500000) can0 Muxed Which=1 (first), One=-0.1 A,B [3 of 8 bytes]\n"
            "(2.000000) can0 Muxed Which=2 (second), Two=120 %\n"
            "(2.500000) can0 7FF#AB (no message of the database)\n");
  EXPECT_NE(sound.err().find("3 frames, 1 of them not defined in"), std::string::npos) << sound.err();
}

TEST_F(Decode, StatesARateWithoutAStampThatSteps) {
  const auto summary_of = [&](const std::string& log) {
    Process program = run(log);
    EXPECT_EQ(program.wait(), done) << program.err();
    return program.err();
  };
  EXPECT_NE(summary_of("(1.000000) can0 7FF#AB\n").find("0 error frames\n"), std::string::npos) << "no time";
  const std::string begin = "(1.000000) can0 7FF#01\n(1.100000) can0 7FF#02\n";
  const std::string ahead =
      begin + "(7.150000) can0 7FE#03\n(1.150000) can0 7FF#04\n(1.200000) can0 7FF#05\n";
  EXPECT_NE(summary_of(ahead).find("; 20 frames/s\n"), std::string::npos) << summary_of(ahead);
  const std::string set_back = begin + "(0.500000) can0 7FF#03\n(0.600000) can0 7FF#04\n";
  EXPECT_NE(summary_of(set_back).find("; 10 frames/s\n"), std::string::npos) << summary_of(set_back);
}

TEST_F(Decode, KeepsTheFlagsOfFdFrames) {
  const std::string log =
      "(1.000000) can0 102##10000803F\n(2.000000) can0 102##00000803F\n(3.000000) can0 7FF##7AB\n";
  Process text = run(log);
  EXPECT_EQ(text.wait(), done) << text.err();
  EXPECT_EQ(text.out(),
            "(1.000000) can0 Float Number=1\n(2.000000) can0 Float Number=1\n"
            "(3.000000) can0 7FF##7AB (no message of the database)\n");
  Process objects = run(log, {"--json"});
  EXPECT_EQ(objects.wait(), done) << objects.err();
  std::istringstream lines(objects.out());
  const std::pair<bool, bool> expected[] = {{true, false}, {false, false}, {true, true}};
  for (const auto& [brs, esi] : expected) {
    std::string line;
    std::getline(lines, line);
    const json frame = json::parse(line);
    EXPECT_EQ(frame.at("kind"), "fd");
    EXPECT_EQ(frame.at("brs"), brs) << line;
    EXPECT_EQ(frame.at("esi"), esi) << line;
  }
}

// PGN 65260 has 17 bytes, too many for one frame. The log contains its announcement to all nodes, and once
// the message in a single frame.
TEST_F(Decode, ReportsEachUndecodedMessageOnceAndDecodesTheRest) {
  write("truck.dbc", R"(VERSION ""
BU_: A
BO_ 2566843392 VehicleId: 17 A
 SG_ Vin : 0|136@1+ (1,0) [0|0] "" A
 SG_ First : 0|8@1+ (1,0) [0|0] "" A
BO_ 256 Half: 4 A
 SG_ Float16 : 0|16@1- (1,0) [0|0] "" A
 SG_ Count : 16|16@1+ (1,0) [0|0] "" A
SIG_VALTYPE_ 256 Float16 : 1;
)");
  const std::string log =
      "(1.000000) can0 100#003C0500\n(2.000000) can0 100#003C0600\n"
      "(3.000000) can0 18ECFF00#20110003FFECFE00\n(4.000000) can0 18ECFF00#20110003FFECFE00\n"
      "(5.000000) can0 18ECFF00#20110003FFEBFE00\n"  // another parameter group, not in the database
      "(6.000000) can0 18FEEC00#4142434445464748\n";
  Process program = run(log, {"--csv"}, "truck.dbc");
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_EQ(program.out(),
            "time_s,interface,id,message,signal,raw,value,unit,name\n"
            "1.000000,can0,100,Half,Count,5,5,,\n2.000000,can0,100,Half,Count,6,6,,\n"
            "6.000000,can0,18FEEC00,VehicleId,First,65,65,,\n");
  const std::string dbc = path("truck.dbc") + ": ";
  const std::string expected =
      dbc +
      "message Half: signal Float16, declared as an IEEE 754 number of 16 bits, is not decoded, expected 1 "
      "to 64 bits, or 32 or 64 for an IEEE 754 number\n" +
      dbc +
      "message VehicleId of 17 bytes uses the transport protocol of J1939 (PGN 65260), which hystcan "
      "does not decode\n" +
      dbc +
      "message VehicleId has 17 bytes, a frame at most 8: hystcan does not join the frames of a "
      "message\n" +
      dbc +
      "message VehicleId: signal Vin, of 136 bits, is not decoded, expected 1 to 64 bits, or 32 or 64 for "
      "an IEEE 754 number\n";
  EXPECT_NE(program.err().find(expected), std::string::npos) << program.err();
}

TEST_F(Decode, CsvHasSeventeenDigitsAndExactRawValues) {
  Process program = run(
      "(1.500000) can0 100#FFFFFFFFFFFFFFFF\n(2.000000) can0 101#01030000\n(3.000000) can0 102#0000C03F\n",
      {"--csv"});
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_EQ(program.out(),
            "time_s,interface,id,message,signal,raw,value,unit,name\n"
            "1.500000,can0,100,Wide,Big,18446744073709551615,1.8446744073709552e+19,,\n"
            "2.000000,can0,101,Muxed,Which,1,1,,first\n"
            "2.000000,can0,101,Muxed,One,3,0.30000000000000004,\"A,B\",\n"
            "3.000000,can0,102,Float,Number,1069547520,1.5,,\n");
}

TEST_F(Decode, JsonHasOneObjectPerFrame) {
  Process program =
      run("(1.500000) can0 100#FFFFFFFFFFFFFFFF\n(2.000000) can0 00000100#AB\n(3.000000) can0 102#0000C07F\n"
          "(4.000000) can0 20000004#0001000000000000\n(5.000000) can0 20000004#000100004C070000\n"
          "(6.000000) can0 101#R2\n",
          {"--json"});
  EXPECT_EQ(program.wait(), done) << program.err();
  std::vector<json> objects;
  std::istringstream lines(program.out());
  for (std::string line; std::getline(lines, line);) objects.push_back(json::parse(line));
  ASSERT_EQ(objects.size(), 6U);
  EXPECT_EQ(objects[0]["time_s"], 1.5);
  EXPECT_EQ(objects[0]["message"], "Wide");
  EXPECT_EQ(objects[0]["signals"]["Big"]["raw"].get<std::uint64_t>(), 0xFFFF'FFFF'FFFF'FFFFU);
  EXPECT_TRUE(objects[1]["message"].is_null()) << "an extended identifier is another message";
  EXPECT_EQ(objects[1]["data"], "AB");
  EXPECT_TRUE(objects[2]["signals"]["Number"]["value"].is_null()) << "JSON has no NaN";
  EXPECT_EQ(objects[2]["signals"]["Number"]["raw"], 0x7FC00000);
  EXPECT_EQ(objects[3]["kind"], "error");
  EXPECT_EQ(objects[4]["lost"], 7);
  EXPECT_EQ(objects[5]["kind"], "remote");
  EXPECT_TRUE(objects[5]["signals"].empty());
  EXPECT_NE(program.err().find("7 frames lost by the recorder"), std::string::npos) << program.err();
}

TEST_F(Decode, ReadsStandardInput) {
  write("a.log", "(1.500000) can0 101#02FFFF\n");
  Process program(
      {"sh", "-c",
       std::string(HYSTCAN_PROGRAM) + " decode - --dbc " + path("small.dbc") + " < " + path("a.log")});
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("Two=131170"), std::string::npos) << program.out();
}

TEST_F(Decode, RefusesABadLogWithFileAndLine) {
  Process program = run("(1.500000) can0 101#01\n(1.600000) can0 101#0\n");
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("a.log:2:22: found the end of the line, expected two hexadecimal digits"),
            std::string::npos)
      << program.err();
  Process absent({HYSTCAN_PROGRAM, "decode", path("no.log"), "--dbc", path("small.dbc")});
  EXPECT_EQ(absent.wait(), bad_input);
  EXPECT_NE(absent.err().find("no.log: cannot be read"), std::string::npos) << absent.err();
  Process folder({HYSTCAN_PROGRAM, "decode", shipped / "", "--dbc", path("small.dbc")});
  EXPECT_EQ(folder.wait(), bad_input);
  Process binary = run(std::string(100'000, '\0'));
  EXPECT_EQ(binary.wait(), bad_input);
}

TEST_F(Decode, MonitorNeedsABus) {
  Process program({HYSTCAN_PROGRAM, "monitor"});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_NE(program.err().find("expected a configuration or --interface"), std::string::npos)
      << program.err();
}

}  // namespace
}  // namespace hystcan::decode_test
