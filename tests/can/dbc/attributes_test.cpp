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

TEST(DbcAttributes, KeepTheirTypes) {
  const Database database = parse_dbc(lab, "lab.dbc");
  EXPECT_EQ(database.warnings, std::vector<std::string>{});
  EXPECT_EQ(database.attributes.at("DBName"), AttributeValue("lab; \"1\""));
  EXPECT_EQ(database.nodes[1].attributes.at("Address"), AttributeValue(std::int64_t{0x1F}));
  EXPECT_EQ(database.find("Fast")->find("S")->attributes.at("GenSigStartValue"), AttributeValue(2.5));
  EXPECT_EQ(database.find("Slow")->attributes.at("VFrameFormat"), AttributeValue("StandardCAN_FD"));
  ASSERT_EQ(database.relation_attributes.size(), 1U);
  const RelationAttribute& relation = database.relation_attributes[0];
  EXPECT_EQ(relation.node, "Sensor");
  EXPECT_EQ(relation.message, "Fast");
  EXPECT_EQ(relation.object, "S");
  EXPECT_EQ(relation.value, AttributeValue(std::int64_t{20}));
}

TEST(DbcAttributes, HaveTheirDefaultWhereNoValueIsGiven) {
  const Database database = parse_dbc(lab, "lab.dbc");
  EXPECT_EQ(*attribute(database, database.find("Fast")->attributes, "VFrameFormat"),
            AttributeValue("StandardCAN"));
  EXPECT_EQ(attribute(database, database.nodes[0].attributes, "Address"), nullptr);
  EXPECT_EQ(attribute(database, {}, "Absent"), nullptr);
}

TEST(DbcAttributes, GiveCycleTimesStartValuesAndCanFd) {
  const Database database = parse_dbc(lab, "lab.dbc");
  EXPECT_EQ(database.find("Fast")->cycle_time_ms, 1.0);
  EXPECT_EQ(database.find("Slow")->cycle_time_ms, 100.0) << "the default";
  EXPECT_EQ(database.find("Event")->cycle_time_ms, std::nullopt)
      << "0 means that the message is not periodic";
  EXPECT_EQ(database.find("Fast")->find("S")->start_value, 2.5);
  EXPECT_FALSE(database.find("Fast")->fd);
  EXPECT_TRUE(database.find("Slow")->fd);
  EXPECT_FALSE(database.find("Event")->fd) << "the attribute decides, not the length";
}

TEST(DbcAttributes, GiveOneWarningForEachIrregularity) {
  const Database database = parse_dbc(
      "BO_ 1 A: 8 X\nBA_DEF_ BO_ \"E\" ENUM \"a\" , \"b\" ;\nBA_DEF_DEF_ \"E\" 1;\nBA_ \"E\" BO_ 1 7;\n"
      "BA_ \"Unknown\" BO_ 1 5;\nBA_DEF_DEF_ \"Other\" 5;\nBA_ \"E\" BO_ 9 \"a\";\n",
      "lab.dbc");
  EXPECT_EQ(*attribute(database, {}, "E"), AttributeValue("b")) << "by number";
  EXPECT_EQ(database.messages[0].attributes.at("Unknown"), AttributeValue(std::int64_t{5}));
  EXPECT_EQ(database.warnings,
            (std::vector<std::string>{"lab.dbc:4:15: attribute 'E' has no item 7",
                                      "lab.dbc:5:6: attribute 'Unknown' is not defined",
                                      "lab.dbc:6:14: a default for attribute 'Other', which is not defined",
                                      "lab.dbc:7:13: there is no message 9"}));
}

}  // namespace
}  // namespace hystcan::can::attributes_test
