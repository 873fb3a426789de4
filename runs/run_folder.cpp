#include "runs/run_folder.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <set>
#include <string_view>
#include <system_error>

namespace hystcan::runs {
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

/// "20261123T092000.123Z" for `date_format` "%Y%m%dT%H%M%S".
template <class Format>
std::string utc_text(const Format& date_format, std::chrono::system_clock::time_point time) {
  const auto since_epoch = std::chrono::floor<std::chrono::milliseconds>(time.time_since_epoch());
  const auto whole_s = std::chrono::floor<std::chrono::seconds>(since_epoch);
  const std::tm date = fmt::gmtime(static_cast<std::time_t>(whole_s.count()));
  return fmt::format(fmt::runtime(date_format), date) +
         fmt::format(".{:03}Z", (since_epoch - whole_s).count());
}

/// The files that settings name: their values are paths, relative to the configuration's folder.
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
               .rate_Hz = config.controller.rate_Hz,
               .started = {},
               .ended = {},
               .failure = {},
               .axes = {},
               .settings = {}};
  for (const config::AxisConfig& axis : config.axes) {
    info.axes.push_back({.name = axis.wire.name,
                         .drive_unit = axis.wire.drive_unit,
                         .stroke_um = axis.control.law.model.stroke(),
                         .delay_s = axis.control.delays.to_sample_s(1.0 / config.controller.rate_Hz),
                         .summary = {}});
  }
  for (const config::Setting& setting : settings) info.settings.emplace_back(setting.path, setting.value);
  return info;
}

RunLock::RunLock(const std::filesystem::path& run)
    : folder_(::open(run.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (folder_.get() >= 0) ::flock(folder_.get(), LOCK_EX | LOCK_NB);
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

}  // namespace hystcan::runs
