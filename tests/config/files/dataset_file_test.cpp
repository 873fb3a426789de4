#include "config/files/dataset_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "base/error.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::dataset_file_test {
namespace {

TEST(DatasetFile, HasALimitOfRows) {
  const support::ShippedCopy folder;
  const std::filesystem::path file = folder / "loops.csv";
  std::ofstream(file) << "time_s,input,output\n0,1,2\n1,2,3\n2,3,4\n";
  EXPECT_EQ(load_dataset(file, {}, 3).dataset.size(), 3U);
  const std::string refusal = support::refusal_of([&] { load_dataset(file, {}, 2); });
  EXPECT_EQ(refusal, file.string() + ":4:1: too many rows, expected at most 2 rows");
}

}  // namespace
}  // namespace hystcan::config::dataset_file_test
