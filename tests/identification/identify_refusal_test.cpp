// Unsuitable datasets and options are refused with a reason.
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "identification/identify.h"
#include "tests/identification/made_record.h"
#include "tests/model/models.h"
#include "tests/support/refusal.h"

namespace hystcan::identification::identify_refusal_test {
namespace {

Dataset sound() { return record_of(model::Hysteresis(model::piezo_model()), 30.0); }

void expect_refused(const std::vector<Dataset>& datasets, const IdentifyOptions& options,
                    const std::string& words) {
  const std::string refusal =
      support::refusal_of<std::invalid_argument>([&] { identify(datasets, options); });
  EXPECT_NE(refusal.find(words), std::string::npos) << refusal << ", expected: " << words;
}

TEST(IdentifyRefuses, AnEmptyListOfDatasets) { expect_refused({}, {}, "no dataset, expected at least one"); }

TEST(IdentifyRefuses, TenSamples) {
  Dataset dataset = sound();
  for (auto* column : {&dataset.time_s, &dataset.input, &dataset.output}) column->resize(10);
  expect_refused({dataset}, {}, "10 samples, expected at least 20");
}

TEST(IdentifyRefuses, ARampWithoutATurningPointAsARecordWithoutALoop) {
  Dataset rising{.input_unit = "V", .output_unit = "um", .time_s = {}, .input = {}, .output = {}};
  for (int i = 0; i < 28; ++i) {
    rising.time_s.push_back(0.1 * i);
    rising.input.push_back(-100.0 + 200.0 / 27.0 * i);
    rising.output.push_back(1e-3 * rising.input.back() * rising.input.back());
  }
  Dataset falling = rising;
  for (double& v : falling.input) v = -v;
  const std::string words = "the input only rises or only falls: the record has no loop";
  for (const ShapeOfOutput output :
       {ShapeOfOutput::automatic, ShapeOfOutput::even, ShapeOfOutput::butterfly, ShapeOfOutput::none}) {
    IdentifyOptions options;
    options.output = output;
    expect_refused({rising, falling}, options, words);
  }
}

TEST(IdentifyRefuses, AConstantInput) {
  Dataset dataset = sound();
  std::ranges::fill(dataset.input, 7.0);
  expect_refused({dataset}, {}, "the input is constant at 7, expected an input that moves");
}

TEST(IdentifyRefuses, AConstantOutput) {
  Dataset dataset = sound();
  std::ranges::fill(dataset.output, -3.0);
  expect_refused({dataset}, {}, "the output is constant at -3, expected an output that follows the input");
}

TEST(IdentifyRefuses, AnOutputThatFallsWhenTheInputRises) {
  Dataset dataset = sound();
  for (double& x : dataset.output) x = -x;
  expect_refused({dataset}, {}, "the output falls when the input rises");
}

TEST(IdentifyRefuses, InputAndOutputInterchanged) {
  Dataset dataset = sound();
  std::swap(dataset.input, dataset.output);
  expect_refused({dataset}, {}, "check that input and output are not interchanged");
}

TEST(IdentifyRefuses, AnOutputThatDoesNotFollowTheInput) {
  Dataset dataset = sound();
  std::ranges::fill(dataset.output, 0.0);
  expect_refused({with_noise(dataset, 1.0, 3)}, {}, "the output ");
}

TEST(IdentifyRefuses, AnOrderTooHighForTheSamples) {
  Dataset dataset = record_of(model::Hysteresis(model::piezo_model()), 1.0);
  ASSERT_GE(dataset.size(), 20U);
  ASSERT_LT(dataset.size(), 50U);
  IdentifyOptions options;
  options.shape = CurveShape::polynomial(10);
  expect_refused({dataset}, options, "order 10 from");
  options.shape = CurveShape::polynomial(21);
  expect_refused({sound()}, options, "expected at most 20");
  for (const int none : {0, -1}) {
    options.shape = CurveShape::polynomial(none);
    expect_refused({sound()}, options, "order " + std::to_string(none) + ", expected at least 1");
  }
}

TEST(IdentifyRefuses, UnseenFlagsThatDoNotMatchTheSamples) {
  IdentifyOptions options;
  options.unseen.assign(1, std::vector<bool>(7, false));
  expect_refused({sound()}, options, "unseen flags of 7 samples, expected ");
  options.unseen.assign(2, std::vector<bool>(sound().size(), false));
  expect_refused({sound()}, options, "unseen flags of 2 datasets, expected 1");
  options.unseen.assign(1, std::vector<bool>(sound().size(), true));
  expect_refused({sound()}, options, "0 samples, expected at least 20");
}

TEST(IdentifyRefuses, DatasetsWithoutCommonInputsUnlessTheyHaveACommonZero) {
  const model::Hysteresis truth(model::piezo_model());
  const auto part = [&](double lo, double hi) {
    return record_of(truth, truth.at_lower_threshold(), travelled({0.0, hi, lo, hi, lo, hi}, 1.0));
  };
  Dataset low = part(0.0, 40.0), high = part(60.0, 100.0);
  for (auto* column : {&high.time_s, &high.input, &high.output})
    column->erase(column->begin(), column->begin() + 61);
  expect_refused({low, high}, {}, "dataset 2 has inputs from 60 to 100, the others from 0 to 40");
  IdentifyOptions options;
  options.common_zero = true;
  EXPECT_NO_THROW(identify({low, high}, options));
  EXPECT_NO_THROW(identify({low, high, part(20.0, 80.0)}, {})) << "the third one ties them together";
}

TEST(IdentifyRefuses, ADelayAsLongAsTheDataset) {
  IdentifyOptions options;
  options.delay_s = sound().time_s.back();
  expect_refused({sound()}, options, "expected less than the duration of a dataset");
}

TEST(IdentifyRefuses, ASecondDatasetThatCannotBeIdentified) {
  Dataset dataset = sound();
  std::ranges::fill(dataset.output, 1.0);
  expect_refused({sound(), dataset}, {}, "the output is constant");
}

}  // namespace
}  // namespace hystcan::identification::identify_refusal_test
