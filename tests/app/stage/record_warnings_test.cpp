// Twenty damaged records, made from one clean record, and the message about each.
#include "app/stage/record_warnings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "identification/dataset.h"
#include "model/hysteresis.h"
#include "tests/identification/made_record.h"
#include "tests/support/piezo.h"
#include "tests/support/refusal.h"

namespace hystcan::app {
namespace {

using identification::Dataset;

/// Some 1500 rows at 1 kHz; row 341 is in the middle of a branch.
Dataset clean() {
  return identification::with_noise(
      identification::record_of(model::Hysteresis(support::piezo_model()), 75.0), 3e-4, 1);
}

struct Spoilt {
  const char* name;
  std::function<void(Dataset&)> spoil;
  std::vector<std::string> said;  ///< parts of the only sentence; empty: no message
  std::size_t left_out = 0;
};

std::function<void(Dataset&)> outputs(std::vector<std::size_t> rows, double value) {
  return [=](Dataset& record) {
    for (const std::size_t row : rows) record.output[row] = value;
  };
}
std::function<void(Dataset&)> inputs(std::vector<std::size_t> rows, double value) {
  return [=](Dataset& record) {
    for (const std::size_t row : rows) record.input[row] = value;
  };
}
std::function<void(Dataset&)> each_output(std::function<double(double)> change) {
  return [=](Dataset& record) { std::ranges::transform(record.output, record.output.begin(), change); };
}

const std::vector<Spoilt>& spoilt_records() {
  const std::size_t last = clean().size() - 1;
  const std::string no_stage = "a stage cannot move like this";
  static const std::vector<Spoilt> all{
      {"nothing", [](Dataset&) {}, {}},
      {"output drops out in one row",
       outputs({340}, 0.0),
       {"output 0 um instead of about", "in row 341 (0.34 s)", "this row is left out"},
       1},
      {"in two rows", outputs({340, 341}, 0.0), {"in row 341 (0.34 s), output 0 um", "row 342 (0.341 s)"}, 2},
      {"in five rows", outputs({340, 341, 342, 343, 344}, -5.0), {"row 344", "and 1 more", no_stage}, 5},
      {"here and there",
       outputs({200, 205, 900, 1200}, 80.0),
       {"row 201", "row 206", "row 901", "row 1201"},
       4},
      {"in the first row", outputs({0}, 60.0), {"output 60 um", "in row 1 (0 s)"}, 1},
      {"in the first two rows", outputs({0, 1}, -20.0), {"row 1 ", "row 2 "}, 2},
      {"in the last row", outputs({last}, 60.0), {"output 60 um", no_stage}, 1},
      {"at a turning point", outputs({75, 76}, 0.0), {"row 76", "row 77"}, 2},
      {"to a great number", outputs({340}, 1e9), {"output 1e+09 um", "row 341"}, 1},
      {"drive glitches upwards", inputs({340}, 130.0), {"input 130 V instead of about", "row 341"}, 1},
      {"downwards", inputs({340}, -40.0), {"input -40 V", "row 341"}, 1},
      {"inside its range", inputs({340}, 0.0), {"input 0 V", "row 341"}, 1},
      {"in two rows", inputs({340, 341}, 130.0), {"row 341", "row 342"}, 2},
      {"in the last row", inputs({last}, 130.0), {"input 130 V"}, 1},
      {"both drop out",
       [](Dataset& record) { record.input[340] = record.output[340] = 0.0; },
       {"input 0 V", "output 0 um"},
       1},
      {"sensor ends above",
       each_output([](double x) { return std::min(x, 24.0); }),
       {"the output stays at 24 um, its highest value, in", "% of all) while the input moves"}},
      {"sensor ends below",
       each_output([](double x) { return std::max(x, 6.0); }),
       {"the output stays at 6 um, its lowest value, in"}},
      {"absolute sensor", each_output([](double x) { return x + 1e7; }), {}},
      {"absolute sensor that drops out",
       [](Dataset& record) {
         for (double& x : record.output) x += 1e5;
         record.output[340] = 0.0;
       },
       {"output 0 um instead of about 1000", "row 341"},
       1},
      {"gain of the sensor", each_output([](double x) { return 1.01 * x; }), {}},
      {"drive begins with a jump",
       [](Dataset& record) {
         for (auto* column : {&record.time_s, &record.input, &record.output})
           column->erase(column->begin() + 1, column->begin() + 40);
       },
       {}},
  };
  return all;
}

TEST(RecordWarnings, NameOnlyTheDamageOfARecord) {
  for (const Spoilt& spoilt : spoilt_records()) {
    SCOPED_TRACE(spoilt.name);
    Dataset record = clean();
    spoilt.spoil(record);
    const std::size_t rows = record.size();
    std::vector<std::string> said;
    for (const RecordWarning& warning : leave_out_suspects("loops.csv", record))
      said.push_back(warning.text());
    EXPECT_EQ(rows - record.size(), spoilt.left_out);
    ASSERT_EQ(said.size(), spoilt.said.empty() ? 0 : 1) << (said.empty() ? "" : said.front());
    for (const std::string& part : spoilt.said)
      EXPECT_NE(said.front().find(part), std::string::npos) << said.front() << "\nexpected: " << part;
  }
}

TEST(RecordWarnings, RefuseTheSameSessionTwice) {
  EXPECT_NO_THROW(refuse_same_rows({"a.csv"}, {clean()}));
  Dataset other = identification::with_noise(clean(), 3e-4, 2);
  EXPECT_NO_THROW(refuse_same_rows({"a.csv", "b.csv"}, {clean(), other}));
  const std::string refusal = support::refusal_of([&] {
    refuse_same_rows({"a.csv", "b.csv", "c.csv"}, {clean(), other, clean()});
  });
  EXPECT_EQ(
      refusal,
      "c.csv: has the same rows as a.csv: both files hold the same session; leave out one of the two files");
}

}  // namespace
}  // namespace hystcan::app
