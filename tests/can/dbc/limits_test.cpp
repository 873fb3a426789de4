// A DBC beyond the limits of can/dbc/database.h is refused with its place, before it costs time or memory.
#include "can/dbc/database.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "can/dbc/message_decoder.h"
#include "tests/can/dbc/refusal.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::can::dbc_limits_test {
namespace {

using namespace dbc;

using dbc_refusal::refusal;

std::string repeat(std::size_t times, const std::string& text) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

std::string numbered(std::size_t count, const std::string& before, const std::string& after) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) all += before + std::to_string(i) + after;
  return all;
}

const std::string one_message = "BO_ 1 M: 8 X\n";
const std::string one_signal = one_message + " SG_ S : 0|8@1+ (1,0) [0|0] \"\" X";

TEST(DbcLimits, ApplyToNamesTextsAndNumbers) {
  EXPECT_EQ(refusal("BO_ 1 " + std::string(longest_name, 'M') + ": 8 X\n"), "accepted");
  EXPECT_EQ(refusal("BO_ 1 " + std::string(longest_name + 1, 'M') + ": 8 X\n"),
            "lab.dbc:1:7: found 1025 bytes, expected at most 1024");
  EXPECT_EQ(refusal("BO_ " + std::string(longest_name + 1, '1') + " M: 8 X\n"),
            "lab.dbc:1:5: found 1025 bytes, expected at most 1024");
  EXPECT_EQ(refusal(one_signal + "\nVAL_ 1 S 1 \"" + std::string(longest_name + 1, 'v') + "\";\n"),
            "lab.dbc:3:13: found 1025 bytes, expected at most 1024");
  EXPECT_EQ(refusal(one_message + "CM_ \"" + std::string(longest_text, 'c') + "\";\n"), "accepted");
  EXPECT_EQ(refusal(one_message + "CM_ \"" + std::string(longest_text + 1, 'c') + "\";\n"),
            "lab.dbc:2:6: found 65537 bytes, expected at most 65536");
}

TEST(DbcLimits, ApplyToMessagesSignalsAndNodes) {
  EXPECT_EQ(refusal(repeat(most_messages + 1, "BO_ 1 M:8\n")),
            "lab.dbc:65537:5: found 65537 messages, expected at most 65536");
  EXPECT_EQ(refusal(one_message + repeat(most_signals + 1, "SG_ S:0|1@1+(1,0)[0|0]\"\"\n")),
            "lab.dbc:65538:5: found 65537 signals of a message, expected at most 65536");
  EXPECT_NE(
      refusal("BU_:" + numbered(most_nodes + 1, " N", "")).find("found 65537 nodes, expected at most 65536"),
      std::string::npos);
}

TEST(DbcLimits, ApplyToListsInOneSection) {
  const auto count_in = [](const std::string& text) {
    const std::string what = refusal(text);
    const auto found = what.find(": found ");
    return found == std::string::npos ? what : what.substr(found + 8);
  };
  EXPECT_EQ(count_in(one_signal + repeat(most_items, ",X") + "\n"),
            "65537 receivers of a signal, expected at most 65536");
  EXPECT_EQ(count_in(one_signal + "\nVAL_ 1 S " + repeat(most_items + 1, "1\"\"") + ";\n"),
            "65537 names of values, expected at most 65536");
  EXPECT_EQ(count_in(one_signal + "\nSG_MUL_VAL_ 1 S S " + repeat(most_items, "1-1,") + "1-1;\n"),
            "65537 ranges of a multiplexer, expected at most 65536");
  EXPECT_EQ(count_in("BA_DEF_ BO_ \"A\" ENUM " + repeat(most_items, "\"\",") + "\"\";\n"),
            "65537 items of an attribute, expected at most 65536");
}

// Each of these files of 400 kB used to need gigabytes.
TEST(DbcLimits, ApplyToCopiesOfASectionToManyObjects) {
  const std::string expected =
      "found too many messages or signals that each store a copy of this section, expected at most 67108864 "
      "bytes for all copies of sections";
  const auto is_refused = [&](const std::string& text) {
    return refusal(text).ends_with(expected) ? std::string("refused") : refusal(text);
  };
  const std::string same_messages = repeat(10'000, "BO_ 1 A:8\nSG_ S:0|8@1+(1,0)[0|0]\"\"\n");
  const std::string same_signals = one_message + repeat(6'000, "SG_ S m1:0|8@1+(1,0)[0|0]\"\"\n");
  const std::string many_values = numbered(20'000, " ", "\"\"") + ";\n";
  std::string every_second;
  for (int i = 0; i < 20'000; ++i) every_second += std::to_string(2 * i) + '-' + std::to_string(2 * i) + ',';
  EXPECT_EQ(is_refused(same_messages + "VAL_ 1 S" + many_values), "refused");
  EXPECT_EQ(is_refused(same_signals + "VAL_ 1 S" + many_values), "refused");
  EXPECT_EQ(is_refused(same_messages + numbered(10'000, "BA_ \"a", "\" BO_ 1 1;\n")), "refused");
  EXPECT_EQ(is_refused(same_messages + repeat(1000, "BA_REL_ \"a\" BU_BO_REL_ N 1 1;\n")), "refused");
  EXPECT_EQ(is_refused(same_messages + "SG_MUL_VAL_ 1 S S " + every_second + "0-0;\n"), "refused");
  EXPECT_EQ(
      is_refused("VAL_TABLE_ T" + many_values + one_message +
                 numbered(4'000, "SG_ S", ":0|8@1+(1,0)[0|0]\"\"\n") + numbered(4'000, "VAL_ 1 S", " T;\n")),
      "refused");
}

TEST(DbcLimits, AreFarAboveASectionThatAppliesToAThousandMessages) {
  const Database database = parse_dbc(repeat(1000, "BO_ 1 A:8\nSG_ S:0|8@1+(1,0)[0|0]\"\"\n") + "VAL_ 1 S" +
                                          numbered(100, " ", "\"value\"") + ";\nCM_ BO_ 1 \"all\";\n",
                                      "lab.dbc");
  EXPECT_EQ(database.messages.back().signals[0].values.size(), 100U);
}

TEST(DbcLimits, LimitTheListOfWarningsButNotTheFile) {
  const Database database = parse_dbc(one_message + ";\n" + std::string(most_warnings + 234, ';'), "lab.dbc");
  EXPECT_EQ(database.warnings.size(), most_warnings);
  EXPECT_EQ(database.warnings.back(), "lab.dbc:3:1000: an extra ';': skipped");
  EXPECT_EQ(database.further_warnings, 234U);
}

TEST(DbcLimits, ApplyToTheSizeOfTheFile) {
  const support::ShippedCopy folder;
  const std::filesystem::path file = folder / "large.dbc";
  std::ofstream(file) << one_message;
  std::filesystem::resize_file(file, largest_file + 1);
  const std::string refusal = support::refusal_of([&] { load_dbc(file); });
  EXPECT_EQ(refusal, file.string() + ": cannot be read: the file has more than 16777216 bytes");
}

TEST(DbcLimits, LeaveTheRangesOfAMultiplexerSortedAndWithoutOverlaps) {
  const Database database =
      parse_dbc(one_message +
                    " SG_ S M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ T m0 : 8|8@1+ (1,0) [0|0] \"\" X\n"
                    "SG_MUL_VAL_ 1 T S 9-9, 1-3, 2-5, 8-7;\n",
                "lab.dbc");
  const auto& ranges = database.messages[0].signals[1].multiplexing.ranges;
  ASSERT_EQ(ranges.size(), 2U);
  EXPECT_EQ(ranges[0].low, 1U);
  EXPECT_EQ(ranges[0].high, 5U);
  for (const auto& [value, is_present] : std::vector<std::pair<int, bool>>{
           {0, false}, {1, true}, {5, true}, {6, false}, {9, true}, {10, false}}) {
    const Frame frame{.id = 1, .length = 2, .data = {static_cast<std::uint8_t>(value), 1}};
    EXPECT_EQ(decode_signals(database.messages[0], frame).size(), is_present ? 2U : 1U) << value;
  }
}

}  // namespace
}  // namespace hystcan::can::dbc_limits_test
