// Names of more than 32 characters: shortened in the file, complete in an attribute.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "can/dbc/database.h"

namespace hystcan::can::long_names_test {
namespace {

using Texts = std::vector<std::string>;

const std::string lab = R"(VERSION ""
BU_: Amp_0001 Sensor
BO_ 385 StatusOfTheAmplifier_0001: 8 Amp_0001
 SG_ OutputOfTheAmplifier_0001 : 0|8@1+ (1,0) [0|0] "V" Sensor,Amp_0001
 SG_ State : 8|8@1+ (1,0) [0|0] "" Sensor
BO_ 386 Sample: 8 Sensor
 SG_ Position : 0|8@1+ (1,0) [0|0] "um" Amp_0001
BA_DEF_ BO_ "SystemMessageLongSymbol" STRING ;
BA_DEF_ SG_ "SystemSignalLongSymbol" STRING ;
BA_DEF_ BU_ "SystemNodeLongSymbol" STRING ;
BA_DEF_REL_ BU_SG_REL_ "Delay" INT 0 10;
BA_DEF_DEF_ "SystemMessageLongSymbol" "";
BA_DEF_DEF_ "SystemSignalLongSymbol" "";
BA_DEF_DEF_ "SystemNodeLongSymbol" "";
BA_ "SystemNodeLongSymbol" BU_ Amp_0001 "AmplifierOfTheUpperStageOnTheLeft";
BA_ "SystemMessageLongSymbol" BO_ 385 "StatusOfTheAmplifierOfTheUpperStage";
BA_ "SystemSignalLongSymbol" SG_ 385 OutputOfTheAmplifier_0001 "OutputOfTheAmplifierOfTheUpperStage";
BA_REL_ "Delay" BU_SG_REL_ Amp_0001 SG_ 385 OutputOfTheAmplifier_0001 5;
VAL_ 385 OutputOfTheAmplifier_0001 1 "one";
)";

Database read(const std::string& text) { return parse_dbc(text, "lab.dbc"); }

TEST(DbcLongNames, AreTheNamesOfMessagesSignalsAndSenders) {
  const Database database = read(lab);
  const Message& status = database.messages[0];
  EXPECT_EQ(status.name, "StatusOfTheAmplifierOfTheUpperStage");
  EXPECT_EQ(status.signals[0].name, "OutputOfTheAmplifierOfTheUpperStage");
  EXPECT_EQ(status.signals[1].name, "State");
  EXPECT_EQ(database.messages[1].name, "Sample") << "the default is empty: there is no long name";
  EXPECT_EQ(status.sender, "AmplifierOfTheUpperStageOnTheLeft");
  EXPECT_EQ(database.warnings, Texts{});
}

TEST(DbcLongNames, DoNotHideSectionsThatUseTheShortName) {
  const Database database = read(lab);
  EXPECT_EQ(database.messages[0].signals[0].values.at(1), "one");
}

TEST(DbcLongNames, FindMessagesAndSignalsAsShortNamesDo) {
  const Database database = read(lab);
  const Message* status = database.find("StatusOfTheAmplifierOfTheUpperStage");
  ASSERT_NE(status, nullptr);
  EXPECT_EQ(database.find("StatusOfTheAmplifier_0001"), status);
  EXPECT_EQ(status->find("OutputOfTheAmplifier_0001"), &status->signals[0]);
  EXPECT_EQ(status->find("OutputOfTheAmplifierOfTheUpperStage"), &status->signals[0]);
  EXPECT_EQ(status->find(""), nullptr);
}

TEST(DbcLongNames, PrecedeShortNamesAndAmbiguousOnesFindNothing) {
  const std::string attributes =
      "BA_DEF_ BO_ \"SystemMessageLongSymbol\" STRING ;\n"
      "BA_ \"SystemMessageLongSymbol\" BO_ 1 \"B\";\nBA_ \"SystemMessageLongSymbol\" BO_ 2 \"C\";\n";
  const Database crossed = read("BO_ 1 A: 1 X\nBO_ 2 B: 1 X\n" + attributes);
  EXPECT_EQ(crossed.find("B")->id, 1U) << "the long name of 1, not the short one of 2";
  EXPECT_EQ(read("BO_ 1 A: 1 X\nBO_ 2 A: 1 X\n" + attributes).find("A"), nullptr);
}

TEST(DbcLongNames, WarnIfTheyAreInvalidOrDuplicate) {
  const Database database = read(
      "BO_ 1 A: 1 X\n SG_ S : 0|4@1+ (1,0) [0|0] \"\" X\n SG_ T : 4|4@1+ (1,0) [0|0] \"\" X\nBO_ 2 B: 1 X\n"
      "BA_DEF_ BO_ \"SystemMessageLongSymbol\" STRING ;\nBA_DEF_ SG_ \"SystemSignalLongSymbol\" STRING ;\n"
      "BA_ \"SystemMessageLongSymbol\" BO_ 1 \"not a name\";\n"
      "BA_ \"SystemSignalLongSymbol\" SG_ 1 T \"S\";\nBA_ \"SystemMessageLongSymbol\" BO_ 2 \"A\";\n");
  EXPECT_EQ(database.messages[0].name, "A");
  EXPECT_EQ(database.messages[1].name, "A");
  EXPECT_EQ(database.find("A")->id, 1U);
  EXPECT_EQ(database.warnings,
            (Texts{"lab.dbc:3:6: signal S occurs a second time in message A: both are kept",
                   "lab.dbc:4:7: message A occurs a second time: this name selects the first message",
                   "lab.dbc:7:38: 'not a name' is not a valid long name: the short name is kept"}));
}

}  // namespace
}  // namespace hystcan::can::long_names_test
