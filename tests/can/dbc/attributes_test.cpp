#include <gtest/gtest.h>

#include <string>

#include "can/dbc/database.h"

namespace hystcan::can::attributes_test {
namespace {

constexpr const char* lab = R"(BU_: Amp Sensor
BO_ 1 Fast: 8 Amp
 SG_ S : 0|8@1+ (1,0) [0|0] "" Sensor
BO_ 2 Slow: 12 Amp
BO_ 3 Event: 16 Amp
EV_ Ambient: 0 [0|0] "" 0 1 DUMMY_NODE_VECTOR0 Amp;
BA_DEF_ BO_  "GenMsgCycleTime" INT 0 65535;
BA_DEF_ BO_  "VFrameFormat" ENUM  "StandardCAN","ExtendedCAN","StandardCAN_FD";
BA_DEF_ SG_  "GenSigStartValue" FLOAT 0 1E+10;
BA_DEF_ BU_  "Address" HEX 0x0 0xFF;
BA_DEF_  "DBName" STRING ;
BA_DEF_ EV_ "Env" INT 0 1;
BA_DEF_REL_ BU_SG_REL_ "Timeout" INT 0 100;
BA_DEF_DEF_  "GenMsgCycleTime" 100;
BA_DEF_DEF_  "VFrameFormat" "StandardCAN";
BA_DEF_DEF_  "GenSigStartValue" 0;
BA_DEF_DEF_  "DBName" "";
BA_DEF_DEF_REL_ "Timeout" 0;
BA_ "DBName" "lab; \"1\"";
BA_ "GenMsgCycleTime" BO_ 1 1;
BA_ "GenMsgCycleTime" BO_ 3 0;
BA_ "VFrameFormat" BO_ 2 2;
BA_ "GenSigStartValue" SG_ 1 S 2.5;
BA_ "Address" BU_ Sensor 0x1F;
BA_ "Env" EV_ Ambient 1;
BA_REL_ "Timeout" BU_SG_REL_ Sensor SG_ 1 S 20;
)";

TEST(DbcAttributes, AreReadInEveryKind) {
  EXPECT_EQ(parse_dbc(lab, "lab.dbc").warnings, std::vector<std::string>{});
}

TEST(DbcAttributes, DefineTheBitRateSwitchOfFdMessages) {
  constexpr const char* text = R"(BO_ 1 Fast: 8 Amp
BO_ 2 Long: 12 Amp
BO_ 3 LongSlow: 12 Amp
BO_ 4 ShortFd: 8 Amp
BA_DEF_ BO_  "VFrameFormat" INT 0 15;
BA_ "VFrameFormat" BO_ 4 14;
)";
  const Database silent = parse_dbc(text, "lab.dbc");
  EXPECT_FALSE(silent.find("Fast")->bit_rate_switch) << "it is not CAN FD";
  EXPECT_TRUE(silent.find("Long")->bit_rate_switch);
  EXPECT_TRUE(silent.find("ShortFd")->bit_rate_switch) << "CAN FD by VFrameFormat";
  const Database stated = parse_dbc(std::string(text) + R"(BA_DEF_ BO_  "CANFD_BRS" ENUM  "0","1";
BA_DEF_DEF_  "CANFD_BRS" "1";
BA_ "CANFD_BRS" BO_ 3 0;
)",
                                    "lab.dbc");
  EXPECT_TRUE(stated.find("Long")->bit_rate_switch);
  EXPECT_FALSE(stated.find("LongSlow")->bit_rate_switch);
}

TEST(DbcAttributes, DefineCanFdMessages) {
  const Database database = parse_dbc(lab, "lab.dbc");
  EXPECT_FALSE(database.find("Fast")->fd) << "the default";
  EXPECT_TRUE(database.find("Slow")->fd) << "by the number of the item";
  EXPECT_FALSE(database.find("Event")->fd) << "the attribute decides, not the length";
}

TEST(DbcAttributes, DefineCanFdByNameOrByVectorNumber) {
  const auto is_fd = [](const std::string& type, const std::string& value) {
    return parse_dbc("BO_ 1 A: 8 X\nBA_DEF_ BO_ \"VFrameFormat\" " + type + ";\nBA_ \"VFrameFormat\" BO_ 1 " +
                         value + ";\n",
                     "lab.dbc")
        .messages[0]
        .fd;
  };
  EXPECT_TRUE(is_fd("INT 0 15", "14"));
  EXPECT_TRUE(is_fd("INT 0 15", "15"));
  EXPECT_FALSE(is_fd("INT 0 15", "1"));
  EXPECT_TRUE(is_fd("STRING ", "\"ExtendedCAN_FD\""));
  EXPECT_FALSE(is_fd("STRING ", "\"14\"")) << "a text is a name";
  EXPECT_TRUE(is_fd("ENUM \"StandardCAN\",\"StandardCAN_FD\"", "\"StandardCAN_FD\""));
}

TEST(DbcAttributes, GiveOneWarningForEachIrregularity) {
  const Database database = parse_dbc(
      "BO_ 1 A: 8 X\nBA_DEF_ BO_ \"E\" ENUM \"a\" , \"b\" ;\nBA_DEF_DEF_ \"E\" 1;\nBA_ \"E\" BO_ 1 7;\n"
      "BA_ \"Unknown\" BO_ 1 5;\nBA_DEF_DEF_ \"Other\" 5;\nBA_ \"E\" BO_ 9 \"a\";\n",
      "lab.dbc");
  EXPECT_EQ(database.warnings,
            (std::vector<std::string>{"lab.dbc:4:15: attribute 'E' has no item 7",
                                      "lab.dbc:5:6: attribute 'Unknown' is not defined",
                                      "lab.dbc:6:14: a default for attribute 'Other', which is not defined",
                                      "lab.dbc:7:13: there is no message 9"}));
}

}  // namespace
}  // namespace hystcan::can::attributes_test
