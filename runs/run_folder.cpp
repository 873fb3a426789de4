#include "runs/run_folder.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <set>
#include <system_error>

#include "base/error.h"

namespace hystcan::runs {
namespace {

using Path = std::filesystem::path;

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

/// Returns a UTC time as text, with milliseconds: "20261123T092000.123Z" for `date_format`
/// "{:%Y%m%dT%H%M%S}".
template <class Format>
std::string utc_text(const Format& date_format, std::chrono::system_clock::time_point time) {
  const auto since_epoch = std::chrono::floor<std::chrono::milliseconds>(time.time_since_epoch());
  const auto whole_s = std::chrono::floor<std::chrono::seconds>(since_epoch);
  const std::tm date = fmt::gmtime(static_cast<std::time_t>(whole_s.count()));
  return fmt::format(fmt::runtime(date_format), date) +
         fmt::format(".{:03}Z", (since_epoch - whole_s).count());
}

/// Returns the configuration file and all files named in the settings. A setting names a file if its value is
/// the path of an existing file, relative to the configuration's folder.
std::set<std::filesystem::path> files_named_by(const RunInfo& info,
                                               const std::filesystem::path& config_file) {
  std::set<std::filesystem::path> files{config_file};
  for (const auto& [key, value] : info.settings) {
    std::error_code ignored;
    if (value.size() < 3 || (value.front() != '"' && value.front() != '\'')) continue;
    const std::filesystem::path file = config_file.parent_path() / value.substr(1, value.size() - 2);
    if (std::filesystem::is_regular_file(file, ignored)) files.insert(file.lexically_normal());
  }
  return files;
}

/// Returns the size of a file; 0 for a symbolic link. The target of a link does not count, because it remains
/// when the link is removed.
std::uintmax_t bytes_of(const Path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(file, error))) return 0;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  return error ? 0 : size;
}

std::uintmax_t bytes_below(const Path& folder) {
  std::uintmax_t bytes = 0;
  std::error_code error;
  if (std::filesystem::is_symlink(folder, error)) return 0;
  std::filesystem::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::recursive_directory_iterator(); entry.increment(error))
    bytes += bytes_of(entry->path());
  return bytes;
}

/// Returns the runs in `folder` that may be removed, in the order of removal: runs without a fault first.
std::vector<Path> removable(const Path& folder, const Path& current) {
  std::vector<Path> runs = runs_in(folder);
  std::erase_if(runs, [&](const Path& run) {
    return run.filename() == current.filename() || is_symlink(run) || exists(run / "keep") ||
           is_being_recorded(run);
  });
  std::stable_partition(runs.begin(), runs.end(), ended_without_fault);
  return runs;
}

/// Returns the removable CSVs of `current`, the run that is being recorded: all except the last one, or none
/// if the run contains a file named `keep`.
std::vector<Path> dispensable_parts(const Path& current) {
  std::vector<Path> parts = exists(current / "keep") ? std::vector<Path>() : parts_of(current);
  if (!parts.empty()) parts.pop_back();
  return parts;
}

}  // namespace

std::string iso_text(std::chrono::system_clock::time_point time) {
  return utc_text("{:%Y-%m-%dT%H:%M:%S}", time);
}

RunInfo describe(const config::Config& config, const std::vector<config::Setting>& settings,
                 const std::string& command) {
  RunInfo info{.version = HYSTCAN_VERSION,
               .host = host_name(),
               .command = command,
               .config = config.file.filename().string(),
               .interface = config.bus.interface,
               .rate_Hz = config.controller.rate_Hz};
  for (const config::AxisConfig& axis : config.axes) {
    info.axes.push_back(
        {.name = axis.wire.name,
         .drive_unit = axis.wire.drive_unit,
         .stroke_um = controller::model_reach_um(axis.control.law.model, axis.control.gate).span(),
         .delay_s = axis.control.delays.to_sample_s(1.0 / config.controller.rate_Hz)});
  }
  for (const config::Setting& setting : settings) info.settings.emplace_back(setting.path, setting.value);
  return info;
}

Descriptor lock_run(const std::filesystem::path& run) {
  Descriptor folder(::open(run.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.get() >= 0) ::flock(folder.get(), LOCK_EX | LOCK_NB);
  return folder;
}

bool is_being_recorded(const std::filesystem::path& run) {
  const Descriptor folder(::open(run.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return folder.get() >= 0 && ::flock(folder.get(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

std::filesystem::path make_run_folder(const std::filesystem::path& folder,
                                      const std::filesystem::path& config_file, const RunInfo& info,
                                      std::chrono::system_clock::time_point now) {
  std::filesystem::create_directories(folder);
  std::filesystem::path run = folder / (run_prefix + utc_text("{:%Y%m%dT%H%M%S}", now));
  if (!std::filesystem::create_directory(run))
    throw std::system_error(std::make_error_code(std::errc::file_exists), run.string());
  try {
    std::filesystem::create_directory(run / "config");
    for (const std::filesystem::path& file : files_named_by(info, config_file))
      std::filesystem::copy_file(file, run / "config" / file.filename(),
                                 std::filesystem::copy_options::overwrite_existing);
    write_run_info(run, info);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove_all(run, ignored);
    throw;
  }
  return run;
}

std::string part_name(const char* what, unsigned number, const char* ending) {
  return fmt::format("{}_{:04}{}", what, number, ending);
}

std::vector<std::filesystem::path> parts_of(const std::filesystem::path& run) {
  std::vector<std::filesystem::path> parts;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(run, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with("cycles_") && name.ends_with(".csv")) parts.push_back(entry->path());
  }
  // Sorts by the length of the name first, so that part 10000 follows part 9999.
  std::ranges::sort(parts, {}, [](const std::filesystem::path& part) {
    const std::string name = part.filename().string();
    return std::pair(name.size(), name);
  });
  return parts;
}

std::vector<std::filesystem::path> runs_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> runs;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->path().filename().string().starts_with(run_prefix) && exists(entry->path() / info_name))
      runs.push_back(entry->path());
  if (error)
    throw Error(folder, fmt::format("cannot be read: {}", error.message()), expect("a folder of runs"));
  std::ranges::sort(runs);
  return runs;
}

std::uintmax_t bytes_of_runs(const Path& folder) {
  std::uintmax_t bytes = 0;
  for (const Path& run : runs_in(folder)) bytes += bytes_below(run);
  return bytes;
}

LimitOutcome keep_limit(const Path& folder, const Path& current, std::uintmax_t most_bytes) {
  LimitOutcome outcome{.removed = {}, .bytes = bytes_of_runs(folder)};
  std::error_code ignored;
  if (outcome.bytes <= most_bytes) return outcome;
  for (const Path& run : removable(folder, current)) {
    if (outcome.bytes <= most_bytes) return outcome;
    outcome.bytes -= std::min(outcome.bytes, bytes_below(run));
    std::filesystem::remove_all(run, ignored);
    outcome.removed.push_back(run.filename().string());
  }
  for (const Path& part : dispensable_parts(current)) {
    if (outcome.bytes <= most_bytes) return outcome;
    const std::uintmax_t size = bytes_of(part);
    if (std::filesystem::remove(part, ignored)) outcome.bytes -= std::min(outcome.bytes, size);
    outcome.removed.push_back(current.filename().string() + "/" + part.stem().string());
  }
  outcome.is_kept = outcome.bytes <= most_bytes;
  return outcome;
}

}  // namespace hystcan::runs
