// Irregularities of real DBC files, and how the reader treats them.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "can/dbc/database.h"

namespace hystcan::can::tolerance_test {
namespace {

using Warnings = std::vector<std::string>;

Database read(const std::string& text) { return parse_dbc(text, "lab.dbc"); }

std::string message(const std::string& signals) { return "BO_ 385 Status: 8 Amp\n" + signals + "\n"; }

/// A signal with these numbers in its line.
Signal signal_of(const std::string& numbers, Warnings* warnings = nullptr) {
  const Database database = read(message(" SG_ S : " + numbers + " \"\" A"));
  if (warnings != nullptr) *warnings = database.warnings;
  return database.messages.at(0).signals.at(0);
}

TEST(DbcTolerance, ReadsNumbersAsToolsWriteThem) {
  Warnings warnings;
  const Signal signal = signal_of("0|0x10@1+ (1.,+5) [.5|1E+05]", &warnings);
  EXPECT_EQ(signal.length, 16);
  EXPECT_EQ(signal.scale, 1.0);
  EXPECT_EQ(signal.offset, 5.0);
  EXPECT_EQ(signal.minimum, 0.5);
  EXPECT_EQ(signal.maximum, 1e5);
  EXPECT_EQ(signal_of("0|16@1+ (1E-05,-.25) [0|1]").scale, 1e-5);
  EXPECT_EQ(signal_of("0|16@1+ (1e-999,0) [0|1]").scale, 0.0) << "a double cannot hold a number so near to 0";
  EXPECT_EQ(warnings, Warnings{});
}

TEST(DbcTolerance, ReadsAnInvalidRangeAsNoRange) {
  Warnings warnings;
  for (const std::string range : {"NAN|NaN", "5|1", "nan|1", "-1.#IND|1.#QNAN", "-nan(ind)|0"}) {
    const Signal signal = signal_of("0|8@1+ (1,0) [" + range + "]", &warnings);
    EXPECT_EQ(signal.minimum, 0.0) << range;
    EXPECT_EQ(signal.maximum, 0.0) << range;
    ASSERT_EQ(warnings.size(), 1U) << range;
  }
  EXPECT_EQ(warnings[0],
            "lab.dbc:2:24: minimum -nan(ind) and maximum 0 of signal S are not a valid range: the "
            "range is ignored");
  const Signal open = signal_of("0|8@1+ (1,0) [-INF|1.#INF]", &warnings);
  EXPECT_EQ(open.minimum, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(open.maximum, std::numeric_limits<double>::infinity());
  EXPECT_EQ(warnings, Warnings{});
}

TEST(DbcTolerance, KeepsSignalsThatCannotBeCodedAndWarns) {
  Warnings warnings;
  EXPECT_EQ(signal_of("0|0@1+ (1,0) [0|0]", &warnings).length, 0);
  EXPECT_EQ(warnings, Warnings{"lab.dbc:2:12: a length of 0 bits of signal S: the signal is not decoded"});
  EXPECT_EQ(signal_of("0|65@1+ (1,0) [0|0]", &warnings).length, 65);
  EXPECT_EQ(warnings.size(), 2U) << "the signal is also outside its message";
  EXPECT_EQ(signal_of("0|8@1+ (0,0) [0|0]", &warnings).scale, 0.0);
  EXPECT_EQ(warnings, Warnings{"lab.dbc:2:18: a scale of 0 of signal S: the signal can't be encoded"});
}

TEST(DbcTolerance, KeepsSignalsOutsideTheirMessageAndWarns) {
  const std::string what = ": signal S reaches beyond the 8 bytes of message Status";
  Warnings warnings;
  signal_of("33|32@1+ (1,0) [0|0]", &warnings);
  EXPECT_EQ(warnings, Warnings{"lab.dbc:2:10" + what});
  signal_of("32|32@1+ (1,0) [0|0]", &warnings);
  EXPECT_EQ(warnings, Warnings{});
  signal_of("38|32@0+ (1,0) [0|0]", &warnings);
  EXPECT_EQ(warnings, Warnings{"lab.dbc:2:10" + what});
  signal_of("39|32@0+ (1,0) [0|0]", &warnings);
  EXPECT_EQ(warnings, Warnings{});
}

TEST(DbcTolerance, WarnsOfSignalsThatOverlap) {
  const Database database =
      read(message(" SG_ A : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ B : 7|4@0+ (1,0) [0|0] \"\" X\n"
                   " SG_ C : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ D m1 : 8|8@1+ (1,0) [0|0] \"\" X"));
  EXPECT_EQ(database.warnings, Warnings{"lab.dbc:3:6: signal B overlaps another signal of message Status"});
}

TEST(DbcTolerance, KeepsDuplicateIdentifiersNamesAndSignals) {
  const std::string one_signal = ": 1 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\n";
  const Database ids = read("BO_ 1 A" + one_signal + "BO_ 1 B" + one_signal + "BO_ 2147483649 C" +
                            one_signal + "VAL_ 1 S 1 \"both\";\n");
  ASSERT_EQ(ids.messages.size(), 3U);
  EXPECT_EQ(ids.messages[0].signals[0].values.at(1), "both");
  EXPECT_EQ(ids.messages[1].signals[0].values.at(1), "both");
  EXPECT_TRUE(ids.messages[2].signals[0].values.empty()) << "standard and extended 1 differ";
  EXPECT_EQ(ids.warnings,
            Warnings{"lab.dbc:3:5: identifier 1 occurs a second time: its frames are decoded as the "
                     "last of these messages"});
  const Database names = read("BO_ 1 A: 1 X\nBO_ 2 A: 1 X\n");
  EXPECT_EQ(names.find("A")->id, 1U);
  EXPECT_EQ(names.warnings,
            Warnings{"lab.dbc:2:7: message A occurs a second time: this name selects the first message"});
  const Database signals =
      read(message(" SG_ S : 0|8@1+ (1,0) [0|0] \"\" A\n SG_ S : 8|8@1+ (1,0) [0|0] \"\" A") +
           "VAL_ 385 S 1 \"on\";");
  EXPECT_EQ(signals.messages[0].signals[0].values.at(1), "on");
  EXPECT_EQ(signals.messages[0].signals[1].values.at(1), "on");
  EXPECT_EQ(signals.warnings,
            Warnings{"lab.dbc:3:6: signal S occurs a second time in message Status: both are kept"});
}

TEST(DbcTolerance, ReadsALongIdentifierWithoutBit31AsExtended) {
  const Database database = read("BO_ 2048 A: 8 X\n");
  EXPECT_TRUE(database.messages[0].extended);
  EXPECT_EQ(database.messages[0].id, 2048U);
  EXPECT_EQ(
      database.warnings,
      Warnings{
          "lab.dbc:1:5: identifier 2048 of message A has more than 11 bits, but bit 31 is not set: it is "
          "read as extended"});
}

TEST(DbcTolerance, ReadsMessagesOfTransportProtocolsAndEmptyMessages) {
  const Database database = read(
      "BO_ 2566843902 Long: 1785 X\n SG_ Last : 14272|8@1+ (1,0) [0|0] \"\" X\nBO_ 1 None: 0\n"
      "BO_ 2 Fd: 64 X\n");
  EXPECT_EQ(database.messages[0].length, 1785);
  EXPECT_FALSE(database.messages[0].fd);
  EXPECT_EQ(database.messages[0].signals[0].start_bit, 14272U);
  EXPECT_EQ(database.messages[1].length, 0);
  EXPECT_TRUE(database.messages[2].fd);
  EXPECT_EQ(database.warnings, Warnings{"lab.dbc:3:7: message None has no sender"});
}

TEST(DbcTolerance, ReadsReceiversWithAnySeparators) {
  const Database database = read(
      message(" SG_ A : 0|1@1+ (1,0) [0|0] \"\"\n SG_ B : 1|1@1+ (1,0) [0|0] \"\" X Y\n"
              " SG_ C : 2|1@1+ (1,0) [0|0] \"\" X , Y,\n  Z\n SG_ D : 3|1@1+ (1,0) [0|0] \"\" Vector__XXX;"));
  const auto& signals = database.messages[0].signals;
  ASSERT_EQ(signals.size(), 4U);
  EXPECT_EQ(database.warnings, Warnings{});
}

TEST(DbcTolerance, SkipsUnknownSections) {
  const Database database = read(
      "VERSION \"\"\nNS_ :\nBS_: 500000 : 1 , 2\nBU_: A\n  B\nFOO_ 1 \"a;b\" 2;\nBO_ 1 M: 8 A\n"
      "SIG_GROUP_ 1 G 1 : S;\nSGTYPE_ T : 8@1+ (1,0) [0|0] \"\" 0, V;\nCAT_DEF_ 1 \"x\" 2;\nFILTER 1 2;\n"
      "// written by hand\n;\nBO_ 2 N: 8 B\n");
  EXPECT_EQ(database.messages.size(), 2U);
  EXPECT_EQ(database.warnings,
            (Warnings{"lab.dbc:6:1: section FOO_ is unknown: skipped",
                      "lab.dbc:12:1: a comment after '//' is not part of the format: the comment is skipped",
                      "lab.dbc:13:1: an extra ';': skipped"}));
}

TEST(DbcTolerance, ReadsNewSymbolsOnOneLineAndAnEmptyList) {
  EXPECT_EQ(read("NS_ : NS_DESC_ CM_ BA_DEF_\nBA_ VAL_\nBS_:\nBU_:\nBO_ 1 A: 8 X").messages.size(), 1U);
  EXPECT_EQ(read("NS_: BS_: BU_: A A\nBO_ 1 A: 8 X").warnings,
            Warnings{"lab.dbc:1:18: node A occurs a second time"});
  EXPECT_EQ(read("NS_ :\nCM_ BU_ B \"of no node\";\n").warnings, Warnings{"lab.dbc:2:9: there is no node B"});
}

TEST(DbcTolerance, SkipsMalformedUnusedCommentsAndDefinitions) {
  const Database database = read(
      "BU_: A B\nBO_ 257 Cmd: 8 A\n SG_ U : 0|16@1+ (0.01,0) [0|100] \"V\" B\n"
      "CM_ 257 \"without its kind; BO_\";\nBA_DEF_ BO_ \"Sendable\" BOOL False True;\nVAL_ 257 U 0 \"off\" "
      ";\n");
  EXPECT_EQ(
      database.warnings,
      (Warnings{"lab.dbc:4:5: found '257', expected BO_, SG_, BU_, EV_ or a comment in quotes: this CM_ is "
                "skipped",
                "lab.dbc:5:24: found 'BOOL', expected INT, HEX, FLOAT, STRING or ENUM: this BA_DEF_ is "
                "skipped"}));
  EXPECT_EQ(database.find("Cmd")->find("U")->values.at(0), "off");
  EXPECT_THROW(read(message("BA_DEF_ BO_ \"VFrameFormat\" BOOL False True;\n")), Error) << "it is kept";
}

TEST(DbcTolerance, WarnsOfAMissingSemicolon) {
  const Database database = read(message(" SG_ S : 0|8@1+ (1,0) [0|0] \"\" A") +
                                 "VAL_ 385 S 1 \"on\"0 \"off\"\nCM_ \"x\";VAL_ 385 S 2 \"on\";");
  EXPECT_EQ(database.messages[0].signals[0].values.size(), 3U);
  EXPECT_EQ(database.warnings, Warnings{"lab.dbc:4:1: found 'CM_' before ';' at the end of the section"});
}

TEST(DbcTolerance, WarnsOfAMissingSemicolonAtTheEndOfTheFile) {
  const Database database =
      read(message(" SG_ S : 0|8@1+ (1,0) [0|0] \"\" A") + "VAL_ 385 S 1 \"on\" 0 \"off\"\n");
  EXPECT_EQ(database.messages[0].signals[0].values.size(), 2U);
  EXPECT_EQ(database.warnings,
            Warnings{"lab.dbc:4:1: the file ends before the last ';': it may be incomplete"});
}

TEST(DbcTolerance, ReadsASwitchMarkedWithALowerCaseM) {
  const Database database =
      read(message(" SG_ A m : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ B m3m : 8|8@1+ (1,0) [0|0] \"\" X\n"
                   " SG_ C m4 : 8|8@1+ (1,0) [0|0] \"\" X"));
  const auto& signals = database.messages[0].signals;
  EXPECT_TRUE(signals[0].multiplexing.is_switch);
  EXPECT_FALSE(signals[0].multiplexing.present_at);
  EXPECT_TRUE(signals[1].multiplexing.is_switch);
  EXPECT_EQ(signals[1].multiplexing.present_at, 3U);
  EXPECT_EQ(signals[2].multiplexing.switched_by, 0U);
  EXPECT_EQ(
      database.warnings,
      (Warnings{"lab.dbc:2:8: the multiplexing mark of signal A ends in m: it is read as M, a switch",
                "lab.dbc:3:8: the multiplexing mark of signal B ends in m: it is read as M, a switch"}));
}

TEST(DbcTolerance, WarnsOfSectionsForAbsentMessagesSignalsAndNodes) {
  const Database database = read(
      "BO_ 1 A: 1 X\nCM_ BO_ 2 \"x\";\nVAL_ 1 B 0 \"x\" ;\nVAL_ Temperature 0 \"x\" ;\n"
      "SIG_VALTYPE_ 2 C : 1;\n"
      "CM_ BU_ Absent \"x\";\nBO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX\n"
      " SG_ Stray : 99|8@1+ (1,0) [0|0] \"\" Vector__XXX\nCM_ SG_ 3221225472 Stray \"x\";\n");
  EXPECT_EQ(database.warnings,
            (Warnings{"lab.dbc:2:9: there is no message 2", "lab.dbc:3:8: message A has no signal B",
                      "lab.dbc:5:14: there is no message 2", "lab.dbc:6:9: there is no node Absent"}));
}

TEST(DbcTolerance, ReadsValueTablesAndSkipsInvalidValues) {
  const Database database =
      read("VAL_TABLE_ OnOff 1 \"on\" 0 \"off\";\n" + message(" SG_ S : 0|8@1- (1,0) [0|0] \"\" A") +
           "VAL_ 385 S OnOff;\nVAL_ 385 S -1 \"bad\" 1.5 \"odd\" 2.0 \"two\";\n");
  EXPECT_EQ(database.messages[0].signals[0].values,
            (std::map<std::int64_t, std::string>{{-1, "bad"}, {0, "off"}, {1, "on"}, {2, "two"}}));
  EXPECT_EQ(database.warnings,
            Warnings{"lab.dbc:5:21: '1.5' is not a raw value of at most 64 bits: the name of "
                     "this value is ignored"});
}

TEST(DbcTolerance, DecidesTheTypeOfAnIeeeSignalByItsLength) {
  const Database database =
      read(message(" SG_ A : 0|64@1- (1,0) [0|0] \"\" X\n SG_ B m0 : 0|16@1- (1,0) [0|0] \"\" X") +
           "SIG_VALTYPE_ 385 A : 1;\nSIG_VALTYPE_ 385 B 1;\n");
  EXPECT_EQ(database.messages[0].signals[0].value_type, ValueType::float64);
  EXPECT_EQ(database.messages[0].signals[1].value_type, ValueType::unreadable);
  EXPECT_FALSE(is_decodable(database.messages[0].signals[1]))
      << "read as an integer it would give a wrong number";
  EXPECT_EQ(
      database.warnings,
      (Warnings{
          "lab.dbc:4:22: signal A of 64 bits can't have value type 1: the type that fits the length is used",
          "lab.dbc:5:20: signal B of 16 bits can't have value type 1: the signal is not decoded"}));
}

TEST(DbcTolerance, ConvertsTextsToUtf8) {
  const auto unit = [](const std::string& text) {
    return read(message(" SG_ S : 0|8@1+ (1,0) [0|0] \"" + text + "\" A")).messages[0].signals[0].unit;
  };
  EXPECT_EQ(unit("\xB0\x43"), "\xC2\xB0\x43") << "Latin-1";
  EXPECT_EQ(unit("\x80 \x96"), "\xE2\x82\xAC \xE2\x80\x93") << "Windows-1252";
  EXPECT_EQ(unit("\xC2\xB0\x43"), "\xC2\xB0\x43") << "UTF-8";
  EXPECT_EQ(unit("\xED\xA0\x80"), "\xC3\xAD\xC2\xA0\xE2\x82\xAC") << "a surrogate is not UTF-8";
  const Database database = read("BU_: K\xFChler\nBO_ 1 A: 1 K\xFChler\nCM_ BU_ K\xFChler \"x\";");
  EXPECT_EQ(database.messages[0].sender, "K\xC3\xBChler");
  EXPECT_EQ(database.warnings, Warnings{});
}

TEST(DbcTolerance, ReadsATextThatEndsWithABackslash) {
  const Database database =
      read("CM_ \"C:\\dir\\\";\n" + message(" SG_ S : 0|8@1+ (1,0) [0|0] \"\" A") +
           "CM_ BO_ 385 \"a \\\"b\\\"; c\\\"\";\nVAL_ 385 S 1 \"a \\\"b\\\"; c\\\"\" 2 \"C:\\\";\n");
  EXPECT_EQ(database.warnings, Warnings{});
  EXPECT_EQ(database.messages[0].signals[0].values,
            (std::map<std::int64_t, std::string>{{1, "a \"b\"; c\""}, {2, "C:\\"}}));
}

TEST(DbcTolerance, AppliesSectionsBeforeTheirMessage) {
  const Database database = read(
      "CM_ BO_ 1 \"early\";\nVAL_ 1 S T;\nBA_ \"VFrameFormat\" BO_ 1 14;\nVAL_TABLE_ T 3 \"three\";\n"
      "BA_DEF_ BO_ \"VFrameFormat\" INT 0 15;\nBO_ 1 A: 1 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\n");
  EXPECT_EQ(database.warnings, Warnings{});
  EXPECT_TRUE(database.messages.at(0).fd);
  EXPECT_EQ(database.messages.at(0).signals.at(0).values.at(3), "three");
}

}  // namespace
}  // namespace hystcan::can::tolerance_test
