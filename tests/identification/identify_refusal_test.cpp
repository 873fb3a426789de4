// What nothing can be identified from is refused, with the reason.
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "identification/identify.h"
#include "tests/identification/made_record.h"
#include "tests/model/models.h"

namespace hystcan::identification {
namespace {

Record sound() { return record_of(model::Hysteresis(model::piezo_model()), 30.0); }

void expect_refused(const std::vector<Record>& records, const IdentifyOptions& options,
                    const std::string& words) {
  try {
    identify(records, options);
    ADD_FAILURE() << "not refused, expected: " << words;
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(IdentifyRefuses, NoRecordAtAll) { expect_refused({}, {}, "no record, expected at least one"); }

TEST(IdentifyRefuses, TenSamples) {
  Record record = sound();
  for (auto* column : {&record.time_s, &record.input, &record.output}) column->resize(10);
  expect_refused({record}, {}, "10 samples, expected at least 20");
}

TEST(IdentifyRefuses, AConstantInput) {
  Record record = sound();
  std::ranges::fill(record.input, 7.0);
  expect_refused({record}, {}, "the input is constant at 7, expected one that moves");
}

TEST(IdentifyRefuses, AConstantOutput) {
  Record record = sound();
  std::ranges::fill(record.output, -3.0);
  expect_refused({record}, {}, "the output is constant at -3, expected one that follows the input");
}

TEST(IdentifyRefuses, AnOutputThatFallsWhereTheInputRises) {
  Record record = sound();
  for (double& x : record.output) x = -x;
  expect_refused({record}, {}, "the output falls where the input rises");
}

TEST(IdentifyRefuses, InputAndOutputInterchanged) {
  Record record = sound();
  std::swap(record.input, record.output);
  expect_refused({record}, {}, "are input and output interchanged?");
}

TEST(IdentifyRefuses, AnOutputThatDoesNotFollowTheInput) {
  Record record = sound();
  std::ranges::fill(record.output, 0.0);
  expect_refused({with_noise(record, 1.0, 3)}, {}, "the output ");
}

TEST(IdentifyRefuses, AnOrderThatTheSamplesCannotTell) {
  Record record = record_of(model::Hysteresis(model::piezo_model()), 1.0);
  ASSERT_GE(record.size(), 20U);
  ASSERT_LT(record.size(), 50U);
  IdentifyOptions options;
  options.order = 10;
  expect_refused({record}, options, "order 10 from");
  options.order = 21;
  expect_refused({sound()}, options, "expected at most 20");
  for (const int none : {0, -1}) {
    options.order = none;
    expect_refused({sound()}, options, "order " + std::to_string(none) + ", expected at least 1");
  }
}

TEST(IdentifyRefuses, WhatIsUnseenWhereItIsNotToldOfEverySample) {
  IdentifyOptions options;
  options.unseen.assign(1, std::vector<bool>(7, false));
  expect_refused({sound()}, options, "seen or not is told of 7 samples, expected ");
  options.unseen.assign(2, std::vector<bool>(sound().size(), false));
  expect_refused({sound()}, options, "seen or not is told of 2 records, expected 1");
  options.unseen.assign(1, std::vector<bool>(sound().size(), true));
  expect_refused({sound()}, options, "0 samples, expected at least 20");
}

TEST(IdentifyRefuses, TheSecondRecordWhereThatIsTheHopelessOne) {
  Record record = sound();
  std::ranges::fill(record.output, 1.0);
  expect_refused({sound(), record}, {}, "the output is constant");
}

}  // namespace
}  // namespace hystcan::identification
