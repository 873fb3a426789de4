#include "runs/run_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "can/regular_file.h"
#include "config/document/error.h"
#include "storage/append_file.h"

namespace hystcan::runs {
namespace {

using nlohmann::json;

constexpr int format_version = 1;
constexpr std::size_t largest_info = 64 << 20;

json to_json(const RunAxis& axis) {
  json faults = json::array();
  for (const RunFault& fault : axis.summary.faults)
    faults.push_back({{"cause", fault.cause}, {"time_s", fault.time_s}});
  return {{"name", axis.name},
          {"drive_unit", axis.drive_unit},
          {"stroke_um", axis.stroke_um},
          {"tracked_rows", axis.summary.tracked_rows},
          {"error_rms_um", axis.summary.rms_um},
          {"error_max_um", axis.summary.max_um},
          {"faults", faults}};
}

RunAxis axis_from(const json& axis) {
  RunAxis result{.name = axis.at("name"),
                 .drive_unit = axis.at("drive_unit"),
                 .stroke_um = axis.at("stroke_um"),
                 .summary = {.tracked_rows = axis.at("tracked_rows"),
                             .rms_um = axis.at("error_rms_um"),
                             .max_um = axis.at("error_max_um"),
                             .faults = {}}};
  for (const json& fault : axis.at("faults"))
    result.summary.faults.push_back({.cause = fault.at("cause"), .time_s = fault.at("time_s")});
  return result;
}

RunInfo info_from(const json& info) {
  RunInfo result{.version = info.at("version"),
                 .host = info.at("host"),
                 .command = info.at("command"),
                 .config = info.at("config"),
                 .interface = info.at("interface"),
                 .rate_Hz = info.at("rate_Hz"),
                 .started = info.at("started"),
                 .ended = info.at("ended"),
                 .failure = info.at("failure"),
                 .first_s = info.at("first_s"),
                 .last_s = info.at("last_s"),
                 .rows = info.at("rows"),
                 .rows_lost = info.at("rows_lost"),
                 .axes = {},
                 .settings = {}};
  for (const json& axis : info.at("axes")) result.axes.push_back(axis_from(axis));
  for (const json& setting : info.at("settings"))
    result.settings.emplace_back(setting.at(0).get<std::string>(), setting.at(1).get<std::string>());
  return result;
}

}  // namespace

json to_json(const RunInfo& info) {
  json axes = json::array(), settings = json::array();
  for (const RunAxis& axis : info.axes) axes.push_back(to_json(axis));
  for (const auto& [key, value] : info.settings) settings.push_back({key, value});
  return {{"hystcan_run", format_version},
          {"version", info.version},
          {"host", info.host},
          {"command", info.command},
          {"config", info.config},
          {"interface", info.interface},
          {"rate_Hz", info.rate_Hz},
          {"started", info.started},
          {"ended", info.ended},
          {"failure", info.failure},
          {"first_s", info.first_s},
          {"last_s", info.last_s},
          {"rows", info.rows},
          {"rows_lost", info.rows_lost},
          {"axes", axes},
          {"settings", settings}};
}

RunInfo read_run_info(const std::filesystem::path& run) {
  const std::filesystem::path file = run / info_name;
  try {
    const json info = json::parse(can::read_regular_file(file, largest_info));
    if (info.at("hystcan_run") != format_version)
      throw config::Error(
          fmt::format("{}: hystcan_run is {}, expected {}: made by another version of hystcan", file.string(),
                      info.at("hystcan_run").dump(), format_version));
    return info_from(info);
  } catch (const can::FileError& error) {
    throw config::Error(
        fmt::format("{}: cannot be read: {}, expected a run's folder", file.string(), error.what()));
  } catch (const json::exception& error) {
    throw config::Error(
        fmt::format("{}: {}, expected what hystcan writes of a run", file.string(), error.what()));
  }
}

void write_run_info(const std::filesystem::path& run, const RunInfo& info) {
  const std::filesystem::path beside = run / (std::string(info_name) + ".new");
  storage::AppendFile file(beside, storage::AppendFile::Existing::replace);
  file.add(to_json(info).dump(2, ' ', false, json::error_handler_t::replace) + "\n");
  file.sync();
  if (const std::error_code error = file.close(); error) {
    std::error_code ignored;
    std::filesystem::remove(beside, ignored);
    throw std::system_error(error, beside.string() + ": cannot be written");
  }
  std::filesystem::rename(beside, run / info_name);
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
  // 10000 comes after 9999.
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
    throw config::Error(
        fmt::format("{}: cannot be read: {}, expected a folder of runs", folder.string(), error.message()));
  std::ranges::sort(runs);
  return runs;
}

}  // namespace hystcan::runs
