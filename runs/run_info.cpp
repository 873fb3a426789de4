#include "runs/run_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/append_file.h"
#include "base/error.h"
#include "base/input_file.h"

namespace hystcan::runs {
namespace {

using nlohmann::json;

constexpr std::uint64_t format_version = 1;
constexpr std::size_t largest_info = 64 << 20;

json to_json(const RunAxis& axis) {
  json faults = json::array();
  for (const RunFault& fault : axis.summary.faults)
    faults.push_back({{"cause", fault.cause}, {"time_s", fault.time_s}});
  return {{"name", axis.name},
          {"drive_unit", axis.drive_unit},
          {"stroke_um", axis.stroke_um},
          {"delay_s", axis.delay_s},
          {"tracked_rows", axis.summary.tracked_rows},
          {"error_rms_um", axis.summary.rms_um},
          {"error_max_um", axis.summary.max_um},
          {"faults", faults}};
}

/// The members of an object of run.json. Each function throws Error, with the file, where the member is missing or
/// is something else.
class Members {
 public:
  Members(const std::filesystem::path& file, const json& object) : file_(file), object_(object) {}

  std::string text(const char* key) const { return of(key, &json::is_string, "a text"); }
  double number(const char* key) const { return of(key, &json::is_number, "a number"); }
  /// NaN where it is null.
  double measured(const char* key) const {
    const auto found = object_.find(key);
    const bool is_none = found != object_.end() && found->is_null();
    return is_none ? std::numeric_limits<double>::quiet_NaN() : number(key);
  }
  /// NaN where it is null or, as in older runs, missing.
  double known(const char* key) const {
    return object_.contains(key) ? measured(key) : std::numeric_limits<double>::quiet_NaN();
  }
  std::uint64_t count(const char* key) const {
    return of(key, &json::is_number_unsigned, "a whole number from 0");
  }
  std::vector<Members> objects(const char* key) const {
    std::vector<Members> result;
    for (const json& element : of(key, &json::is_array, "a list")) {
      if (!element.is_object()) refuse(key, element, "a list of objects");
      result.emplace_back(file_, element);
    }
    return result;
  }
  std::vector<std::pair<std::string, std::string>> pairs(const char* key) const {
    std::vector<std::pair<std::string, std::string>> result;
    for (const json& pair : of(key, &json::is_array, "a list")) {
      if (!pair.is_array() || pair.size() != 2 || !pair[0].is_string() || !pair[1].is_string())
        refuse(key, pair, "pairs of texts");
      result.emplace_back(pair[0], pair[1]);
    }
    return result;
  }

 private:
  const json& of(const char* key, bool (json::*is_right)() const noexcept, const char* expected) const {
    const auto found = object_.find(key);
    if (found == object_.end())
      throw Error(fmt::format("{}: {} is missing, expected {}", file_.string(), key, expected));
    if (!((*found).*is_right)()) refuse(key, *found, expected);
    return *found;
  }
  [[noreturn]] void refuse(const char* key, const json& found, const char* expected) const {
    constexpr std::size_t longest = 40;
    const std::string text =  // dump() goes down by recursion
        found.is_structured() ? found.type_name() : found.dump(-1, ' ', true, json::error_handler_t::replace);
    throw Error(fmt::format("{}: {} is {}{}, expected {}", file_.string(), key, text.substr(0, longest),
                            text.size() > longest ? "..." : "", expected));
  }

  const std::filesystem::path& file_;
  const json& object_;
};

RunAxis axis_from(const Members& axis) {
  RunAxis result{.name = axis.text("name"),
                 .drive_unit = axis.text("drive_unit"),
                 .stroke_um = axis.number("stroke_um"),
                 .delay_s = axis.known("delay_s"),
                 .summary = {.tracked_rows = axis.count("tracked_rows"),
                             .rms_um = axis.measured("error_rms_um"),
                             .max_um = axis.measured("error_max_um"),
                             .faults = {}}};
  for (const Members& fault : axis.objects("faults"))
    result.summary.faults.push_back({.cause = fault.text("cause"), .time_s = fault.number("time_s")});
  return result;
}

RunInfo info_from(const Members& info) {
  RunInfo result{.version = info.text("version"),
                 .host = info.text("host"),
                 .command = info.text("command"),
                 .config = info.text("config"),
                 .interface = info.text("interface"),
                 .rate_Hz = info.number("rate_Hz"),
                 .started = info.text("started"),
                 .ended = info.text("ended"),
                 .failure = info.text("failure"),
                 .first_s = info.number("first_s"),
                 .last_s = info.number("last_s"),
                 .rows = info.count("rows"),
                 .rows_lost = info.count("rows_lost"),
                 .axes = {},
                 .settings = info.pairs("settings")};
  for (const Members& axis : info.objects("axes")) result.axes.push_back(axis_from(axis));
  return result;
}

json parsed(const std::filesystem::path& file, const std::string& text) {
  std::string what;
  try {
    json info = json::parse(text);
    if (info.is_object()) return info;
    what = "no JSON object";
  } catch (const json::parse_error& error) {
    what = fmt::format("no JSON at byte {}", error.byte);
  } catch (const json::out_of_range&) {  // 1e999
    what = "a number that is too large";
  }
  throw Error(fmt::format("{}: {}, expected what hystcan writes of a run", file.string(), what));
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
    const json object = parsed(file, read_regular_file(file, largest_info));
    const Members info(file, object);
    if (const std::uint64_t version = info.count("hystcan_run"); version != format_version)
      throw Error(fmt::format("{}: hystcan_run is {}, expected {}: made by another version of hystcan",
                              file.string(), version, format_version));
    return info_from(info);
  } catch (const FileError& error) {
    throw Error(fmt::format("{}: cannot be read: {}, expected a run's folder", file.string(), error.what()));
  }
}

void write_run_info(const std::filesystem::path& run, const RunInfo& info) {
  const std::filesystem::path beside = run / (std::string(info_name) + ".new");
  AppendFile file(beside, AppendFile::Existing::replace);
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
    throw Error(
        fmt::format("{}: cannot be read: {}, expected a folder of runs", folder.string(), error.message()));
  std::ranges::sort(runs);
  return runs;
}

}  // namespace hystcan::runs
