// Runs `hystcan simulate` over 10^7 rows as a process, CSV to CSV and HDF5 to HDF5, and compares it with the
// model alone in memory.
//
//   bench_simulate [FOLDER]      default: the temporary folder; needs 1.5 GB there
//   bench_simulate --model       the model alone
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/text.h"
#include "config/files/model_file.h"
#include "model/hysteresis_operator.h"
#include "tests/bench/budgets.h"
#include "tests/bench/short_run.h"

namespace {

using namespace hystcan;

const int rows = bench::full_or_short(10'000'000, 1'000'000);
constexpr int repetitions = 3;  // from the second one on, a file is replaced
constexpr const char* model_file = HYSTCAN_SOURCE_DIR "/config/piezo.model.toml";

double input(int row) {
  const double time_s = 1e-4 * row;
  return 50.0 + 35.0 * std::sin(8.2 * time_s) * std::exp(-time_s / 2000.0) + 3.0 * std::sin(44.6 * time_s);
}

void write_input(const std::filesystem::path& file) {
  std::ofstream out(file);
  std::string text = "time_s,input\n";
  for (int i = 0; i < rows; ++i) {
    append_shortest(text, 1e-4 * i);
    text += ',';
    append_shortest(text, input(i));
    text += '\n';
    if (text.size() < 1 << 20) continue;
    out << text;
    text.clear();
  }
  out << text;
}

/// Returns the processor time of this process and of its child programs, which other programs hardly disturb.
double processor_s() {
  double sum_s = 0.0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    for (const timeval& time : {usage.ru_utime, usage.ru_stime})
      sum_s += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  }
  return sum_s;
}

template <class Work>
double best_s(const Work& work) {
  double best = 1e9;
  for (int i = 0; i < repetitions; ++i) {
    const double begin_s = processor_s();
    work();
    best = std::min(best, processor_s() - begin_s);
  }
  return best;
}

double model_alone_s() {
  std::vector<double> inputs(static_cast<std::size_t>(rows));
  for (int i = 0; i < rows; ++i) inputs[static_cast<std::size_t>(i)] = input(i);
  const model::Hysteresis model{config::load_model(model_file)};
  return best_s([&] {
    std::vector<double> outputs(inputs.size());
    model::HysteresisState state = model.virgin(model.input_range().lo, 4096);
    for (std::size_t i = 0; i < inputs.size(); ++i) outputs[i] = model.advance(state, inputs[i]).value;
  });
}

/// Returns the processor time of `hystcan simulate`. If it fails, prints its messages and throws.
double program_s(const std::string& program, const std::filesystem::path& from,
                 const std::filesystem::path& to) {
  const std::string messages = to.string() + ".messages";
  const std::string command =
      fmt::format("'{}' simulate '{}' --input '{}' --output '{}' --overwrite >'{}' 2>&1", program, model_file,
                  from.string(), to.string(), messages);
  return best_s([&] {
    if (std::system(command.c_str()) == 0) return;
    std::cerr << std::ifstream(messages).rdbuf();
    throw std::runtime_error("failed: " + command);
  });
}

/// A folder that the destructor removes.
struct Folder {
  explicit Folder(std::filesystem::path at) : path(std::move(at)) {
    std::filesystem::create_directories(path);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path operator/(const char* name) const { return path / name; }

  std::filesystem::path path;
};

void time_the_program(bench::Budgets& budgets, const std::filesystem::path& parent, double alone_s) {
  const Folder folder(parent / fmt::format("hystcan-bench-simulate-{}", getpid()));
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "hystcan";
  write_input(folder / "in.csv");
  const double csv_s = program_s(program, folder / "in.csv", folder / "out.csv");
  budgets.print("CSV to CSV, s", csv_s);
  budgets.ratio("simulate, CSV to CSV, all threads / model alone", csv_s / alone_s, {15.0, 26.7});
  program_s(program, folder / "in.csv", folder / "in.h5");
  budgets.print("HDF5 to HDF5, s", program_s(program, folder / "in.h5", folder / "out.h5"));
}

}  // namespace

int main(int argc, char** argv) try {
  const double alone_s = model_alone_s();
  fmt::print("{:<14} {:8.6f} s  {} rows\n", "model alone", alone_s, rows);
  if (argc > 1 && std::string_view(argv[1]) == "--model") return 0;
  bench::Budgets budgets("bench_simulate");
  budgets.print_heading();
  time_the_program(budgets, argc > 1 ? argv[1] : std::filesystem::temp_directory_path(), alone_s);
  return budgets.status();
} catch (const std::exception& error) {  // caught, so that the destructor removes the folder
  std::cerr << error.what() << '\n';
  return 1;
}
