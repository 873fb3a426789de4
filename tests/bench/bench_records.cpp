// The identification of records of twenty shapes: those that are made here, from a Preisach model that no fit
// can equal, and the measured ones where they are (HYSTCAN_DATA). Seconds of processor time beside the
// budget, the slowest last.
//
//   bench_records
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "config/files/dataset_file.h"
#include "config/files/model_file.h"
#include "identification/identify.h"
#include "model/any_model.h"
#include "model/preisach.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/short_run.h"

namespace {

using namespace hystcan;
using identification::Dataset;

/// The input at a time from 0 to 1, in shares of the range.
using Course = std::function<double(double)>;

double triangle(double cycles, double t) {
  const double phase = std::fmod(cycles * t, 1.0);
  return phase < 0.5 ? 2.0 * phase : 2.0 - 2.0 * phase;
}
double sine(double cycles, double t) { return 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * cycles * t); }

struct Shape {
  const char* name;
  double seconds;
  Course course;
};

std::vector<Shape> shapes() {
  return {
      {"one triangle", 40.0, [](double t) { return triangle(1.0, t); }},
      {"three triangles", 10.0, [](double t) { return triangle(3.0, t); }},
      {"growing triangles", 10.0, [](double t) { return (0.2 + 0.8 * t) * triangle(12.0, t); }},
      {"decaying triangles", 20.0, [](double t) { return 0.5 + (1.0 - t) * (triangle(15.0, t) - 0.5); }},
      {"growing sines", 5.0, [](double t) { return (0.1 + 0.9 * t) * sine(20.0, t); }},
      {"a sine that gets faster", 5.0, [](double t) { return sine(2.0 + 10.0 * t, t); }},
      {"reversal curves", 30.0, [](double t) { return 1.0 - (1.0 - triangle(10.0, t)) * (0.1 + 0.9 * t); }},
      {"two sines", 8.0, [](double t) { return 0.7 * sine(3.0, t) + 0.3 * sine(31.0, t); }},
      {"a staircase", 12.0, [](double t) { return std::round(8.0 * triangle(3.0, t)) / 8.0; }},
      {"one cycle of a sine", 10.0, [](double t) { return sine(1.0, t); }}};
}

Dataset made(const model::Preisach& truth, const Shape& shape, std::size_t rows) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.01);
  model::HysteresisState state = truth.at_lower_threshold();
  const model::Interval range = truth.parameters().input_range;
  Dataset dataset{"V", "um", {}, {}, {}};
  for (std::size_t i = 0; i < rows; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(rows - 1);
    dataset.time_s.push_back(shape.seconds * t);
    dataset.input.push_back(range.lo + range.span() * shape.course(t));
    dataset.output.push_back(truth.advance(state, dataset.input.back()).value + noise(random));
  }
  return dataset;
}

struct Row {
  std::string name;
  std::size_t rows;
  double seconds, rms_percent, budget_s;
};

void time_it(std::vector<Row>& rows, std::string name, const std::vector<Dataset>& datasets,
             double budget_s) {
  std::size_t count = 0;
  for (const Dataset& dataset : datasets) count += dataset.size();
  const double before = bench::cpu_s();
  try {
    const identification::Identified found = identification::identify(datasets, {});
    rows.push_back({std::move(name), count, bench::cpu_s() - before,
                    100.0 * found.overall.rms / found.output_span, budget_s});
  } catch (const std::exception& error) {
    std::printf("%s: %s\n", name.c_str(), error.what());
  }
}

void time_measured(std::vector<Row>& rows) {
  const char* folder = std::getenv("HYSTCAN_DATA");
  if (folder == nullptr || bench::is_short()) {
    std::puts("no measured records: set HYSTCAN_DATA");
    return;
  }
  std::vector<Dataset> sessions;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  std::ranges::sort(files);
  for (const std::filesystem::path& file : files) {
    try {
      const Dataset dataset = config::load_dataset(file).dataset;
      const std::string name = file.stem().string();
      if (name.starts_with("piezo_stage")) sessions.push_back(dataset);
      time_it(rows, name, {dataset}, 1.0);
    } catch (const std::exception&) {  // another layout
    }
  }
  if (sessions.size() > 1) time_it(rows, "all sessions of the piezo stage", sessions, 2.0);
}

}  // namespace

int main() {
  bench::announce_short_run();
  const auto parameters = config::load_any_parameters(HYSTCAN_SOURCE_DIR "/config/soft_stage.plant.toml");
  const model::Preisach truth(std::get<model::PreisachParameters>(parameters));
  std::vector<Row> rows;
  for (const Shape& shape : shapes())
    for (const std::size_t count : {std::size_t{1000}, bench::full_or_short<std::size_t>(20'000, 1500)})
      time_it(rows, shape.name, {made(truth, shape, count)}, 3.0);
  time_measured(rows);
  std::ranges::sort(rows, {}, &Row::seconds);
  for (const Row& row : rows)
    std::printf("%-34s %6zu rows  %6.2f s, budget %.0f s: %-10s %.3g %% RMS\n", row.name.c_str(), row.rows,
                row.seconds, row.budget_s, bench::verdict(row.seconds <= row.budget_s), row.rms_percent);
  return 0;
}
