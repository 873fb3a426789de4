#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "app/commands.h"
#include "config/csv.h"
#include "model/simulation.h"

namespace hystcan::app {
namespace {

struct Options {
  std::filesystem::path model;
  std::filesystem::path input;
  std::filesystem::path output;
  bool inverse = false;
};

/// A file that is complete or not there: written beside its place, moved there by commit(). What is there and
/// is no ordinary file (a device, a pipe, a link) is written to as it is.
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path path) : path_(std::move(path)) {
    const auto status = std::filesystem::symlink_status(path_);
    replaces_ = !std::filesystem::exists(status) || std::filesystem::is_regular_file(status);
    written_ = path_;
    if (replaces_) written_ += ".part";
    file_ = std::fopen(written_.c_str(), "w");
    if (file_ == nullptr) fail();
  }
  ~OutputFile() {
    if (file_ == nullptr) return;
    std::fclose(file_);
    if (replaces_) std::remove(written_.c_str());
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text) {
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail();
  }
  void commit() {
    if (std::fclose(std::exchange(file_, nullptr)) != 0) fail();
    if (replaces_) std::filesystem::rename(written_, path_);
  }

 private:
  [[noreturn]] void fail() const {
    const int error = errno;
    throw RunError(
        fmt::format("{}: cannot be written: {}", path_.string(), std::generic_category().message(error)));
  }

  std::filesystem::path path_;
  std::filesystem::path written_;
  bool replaces_ = true;
  std::FILE* file_ = nullptr;
};

/// An output that is one of the inputs would be lost while it is read.
void refuse_to_overwrite(const std::filesystem::path& output, const std::filesystem::path& input) {
  std::error_code ignored;
  if (std::filesystem::equivalent(output, input, ignored))
    throw config::Error(fmt::format("{}: is read too, expected another file as output", output.string()));
}

int simulate(const Options& options) {
  refuse_to_overwrite(options.output, options.model);
  refuse_to_overwrite(options.output, options.input);
  const model::Hysteresis hysteresis(config::load_model(options.model));
  model::Simulation simulation(hysteresis);
  const bool timed = config::CsvReader::has_column(options.input, "time_s");
  std::vector<std::string> columns{options.inverse ? "output" : "input"};
  if (timed) columns.emplace_back("time_s");
  config::CsvReader reader(options.input, columns);

  OutputFile out(options.output);
  out.write("time_s,input,output\n");
  const model::Simulation::Tally& tally = simulation.tally();
  std::vector<double> given;
  while (reader.next(given)) {
    const double time_s = timed ? given[1] : static_cast<double>(tally.rows);
    const auto row = options.inverse ? simulation.follow_output(given[0]) : simulation.follow_input(given[0]);
    out.write(fmt::format("{:.17g},{:.17g},{:.17g}\n", time_s, row.input, row.output));
  }
  if (tally.rows == 0)
    throw config::Error(
        fmt::format("{}: has a header only, expected at least one row", options.input.string()));
  out.commit();
  fmt::print(stderr, "{}: {} rows, {} of them limited to the thresholds {} and {} {}\n",
             options.output.string(), tally.rows, tally.saturated, hysteresis.input_range().lo,
             hysteresis.input_range().hi, hysteresis.parameters().input_unit);
  if (tally.not_increasing > 0)
    fmt::print(stderr, "{} rows lie on a branch that is not increasing: do not trust its inverse there\n",
               tally.not_increasing);
  return done;
}

}  // namespace

void add_simulate(CLI::App& cli, int& status) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      cli.add_subcommand("simulate", "Run a hysteresis model, or its inverse, over a CSV record");
  command->add_option("MODEL", options->model, "model file (TOML)")->required();
  command->add_option("--input", options->input, "CSV with a column `input` (with --inverse: `output`)")
      ->required();
  command->add_option("--output", options->output, "CSV to write: time_s,input,output, 17 digits")
      ->required();
  command->add_flag("--inverse", options->inverse, "from output to the input that gives it");
  command->callback([options, &status] { status = simulate(*options); });
}

}  // namespace hystcan::app
