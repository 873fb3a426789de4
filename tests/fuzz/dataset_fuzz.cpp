// For any bytes as a lab's CSV and any of these layouts, load_dataset either refuses the file with its place,
// or returns columns of equal length with numbers that a fit can square and with increasing time. The refusal
// of a column names no place.
#include <cmath>
#include <vector>

#include "config/files/dataset_file.h"
#include "tests/fuzz/refusal.h"

using namespace hystcan;

namespace {

const std::vector<config::DatasetLayout> layouts{{},
                                                 {.columns = "1,2,3"},
                                                 {.columns = "t,V,x"},
                                                 {.columns = "2,1", .rate_Hz = 1e3},
                                                 {.rate_Hz = 1e-3, .output_scale = 1e3},
                                                 {.columns = ",", .rate_Hz = 1.0, .output_scale = -0.1}};

bool is_within(const std::vector<double>& column) {
  for (const double value : column)
    if (!(std::abs(value) <= identification::largest_value)) return false;
  return true;
}

void demand_a_dataset(const identification::Dataset& dataset) {
  fuzz::demand(dataset.time_s.size() == dataset.size() && dataset.output.size() == dataset.size());
  fuzz::demand(is_within(dataset.time_s) && is_within(dataset.input) && is_within(dataset.output));
  for (std::size_t i = 1; i < dataset.size(); ++i) fuzz::demand(dataset.time_s[i] > dataset.time_s[i - 1]);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::File file(data, size);
  for (const config::DatasetLayout& layout : layouts) try {
      demand_a_dataset(config::load_dataset(file.path(), layout, 1000).dataset);
    } catch (const Error& error) {
      const std::string_view what = error.what();
      fuzz::demand(what.starts_with(file.path().string() + ":") || what.starts_with("--columns is "));
      fuzz::demand_advice(what);
    }
  return 0;
}
