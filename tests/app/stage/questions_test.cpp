#include "app/stage/questions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "tests/support/refusal.h"

namespace hystcan::app::questions_test {
namespace {

const Question highest{"--drive-max", "Highest drive", "V",
                       "the controller commands no drive above this limit"};

std::optional<std::string> more_than_zero(double value) {
  return unless(value > 0.0, "expected more than 0");
}

TEST(Questions, AreRepeatedUntilTheAnswerIsValid) {
  std::istringstream answers("abc\n-5\n 1e2 \n");
  testing::internal::CaptureStderr();
  Questions questions(answers, true);
  EXPECT_EQ(questions.number(highest, {}, {}, more_than_zero), 100.0);
  const std::string shown = testing::internal::GetCapturedStderr();
  EXPECT_NE(shown.find("'abc', expected a number"), std::string::npos) << shown;
  EXPECT_NE(shown.find("expected more than 0"), std::string::npos) << shown;
  EXPECT_EQ(questions.asked(), 1) << "asked again is the same question";
}

TEST(Questions, AcceptCommasAndUnits) {
  for (const auto& [typed, unit, expected] :
       std::vector<std::tuple<std::string, std::string, double>>{{"60,5", "um", 60.5},
                                                                 {"60 um", "um", 60.0},
                                                                 {"60\xC2\xB5m", "um", 60.0},
                                                                 {"0.06 mm", "um", 60.0},
                                                                 {"0.31 kHz", "Hz", 310.0},
                                                                 {"0,31kHz", "Hz", 310.0},
                                                                 {"-20 V", "V", -20.0},
                                                                 {"300 us", "us", 300.0}}) {
    std::istringstream answers(typed + "\n");
    Questions questions(answers, true);
    EXPECT_NEAR(questions.number({"--x", "X", unit, ""}, {}, {}), expected, 1e-9) << typed;
  }
  std::istringstream answers("60 V\n1,000.5\n60 kg\n2\n");
  Questions questions(answers, true);
  EXPECT_EQ(questions.number({"--x", "X", "um", ""}, {}, {}), 2.0);
}

TEST(Questions, AreRepeatedIfACommaMaySeparateThousands) {
  std::istringstream answers("1,234\n1,500 Hz\n-2,000\n1,2345\n");
  testing::internal::CaptureStderr();
  Questions questions(answers, true);
  EXPECT_EQ(questions.number({"--x", "X", "Hz", ""}, {}, {}), 1.2345);
  const std::string shown = testing::internal::GetCapturedStderr();
  for (const char* typed : {"1,234", "1,500 Hz", "-2,000"})
    EXPECT_NE(
        shown.find("'" + std::string(typed) + "' has a comma before three digits; write a decimal point"),
        std::string::npos)
        << shown;
}

TEST(Questions, HaveAUnitAReasonAnOptionAndADefault) {
  std::istringstream answers("\n");
  testing::internal::CaptureStderr();
  EXPECT_EQ(Questions(answers, true).number(highest, {}, 120.0), 120.0);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "Highest drive, V: the controller commands no drive above this limit\n  --drive-max [120]: ");
}

TEST(Questions, AreSkippedIfTheOptionIsGiven) {
  std::istringstream answers;
  Questions questions(answers, true);
  EXPECT_EQ(questions.number(highest, 80.0, 120.0), 80.0);
  EXPECT_EQ(questions.asked(), 0);
}

TEST(Questions, RefuseAStatedValueByTheNameOfItsOption) {
  std::istringstream answers;
  const std::string refusal =
      support::refusal_of([&] { Questions(answers, true).number(highest, -1.0, {}, more_than_zero); });
  EXPECT_EQ(refusal, "--drive-max: expected more than 0");
}

TEST(Questions, ListAllMissingOptionsAtOnce) {
  std::istringstream answers("not read");
  Questions questions(answers, false);
  EXPECT_TRUE(std::isnan(questions.number(highest, {}, {})));
  EXPECT_EQ(questions.number({"--safe", "Safe drive", "V", ""}, {}, 0.0), 0.0);
  EXPECT_EQ(questions.text({"--dbc", "DBC", "", ""}, {}, {}), "");
  const std::string refusal = support::refusal_of([&] { questions.require_all(); });
  EXPECT_EQ(refusal.substr(0, 30), "--drive-max, --dbc are missing");
}

TEST(Questions, GoBackByOneOnALessSign) {
  std::istringstream answers("5\n7\n<\n<\n6\n8\n9\n");
  Questions questions(answers, true);
  std::vector<double> given;
  int begun = 0;
  for (bool complete = false; !complete;) try {
      ++begun;
      given.clear();
      questions.begin();
      for (int i = 0; i < 3; ++i) given.push_back(questions.number(highest, {}, {}, more_than_zero));
      complete = true;
    } catch (const Questions::StepBack&) {
    }
  EXPECT_EQ(given, (std::vector<double>{6.0, 8.0, 9.0}));
  EXPECT_EQ(begun, 3);
  EXPECT_EQ(questions.asked(), 3);
}

TEST(Questions, EndWithTheInput) {
  std::istringstream answers("x\n");
  Questions questions(answers, true);
  EXPECT_THROW(questions.number(highest, {}, 1.0), RunError);
}

}  // namespace
}  // namespace hystcan::app::questions_test
