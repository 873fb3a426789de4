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

enum class Null : std::uint8_t { no, allowed, or_missing };  ///< or_missing: as in older runs

template <class V>
void visit(V& v, RunFault& fault) {
  v.value("cause", fault.cause);
  v.value("time_s", fault.time_s);
}

template <class V>
void visit(V& v, RunAxis& axis) {
  v.value("name", axis.name);
  v.value("drive_unit", axis.drive_unit);
  v.value("stroke_um", axis.stroke_um);
  v.value("delay_s", axis.delay_s, Null::or_missing);
  v.value("tracked_rows", axis.summary.tracked_rows);
  v.value("error_rms_um", axis.summary.rms_um, Null::allowed);
  v.value("error_max_um", axis.summary.max_um, Null::allowed);
  v.list("faults", axis.summary.faults);
}

template <class V>
void visit(V& v, RunInfo& info) {
  v.value("version", info.version);
  v.value("host", info.host);
  v.value("command", info.command);
  v.value("config", info.config);
  v.value("interface", info.interface);
  v.value("rate_Hz", info.rate_Hz);
  v.value("started", info.started);
  v.value("ended", info.ended);
  v.value("failure", info.failure);
  v.value("first_s", info.first_s);
  v.value("last_s", info.last_s);
  v.value("rows", info.rows);
  v.value("rows_lost", info.rows_lost);
  v.list("axes", info.axes);
  v.value("settings", info.settings);
}

/// Makes the object of run.json.
class Written {
 public:
  template <class T>
  explicit Written(T value) {
    visit(*this, value);
  }

  /// NaN becomes null.
  template <class T>
  void value(const char* key, const T& value, Null = {}) {
    object[key] = value;
  }
  template <class T>
  void list(const char* key, const std::vector<T>& values) {
    object[key] = json::array();
    for (const T& value : values) object[key].push_back(Written(value).object);
  }

  json object;
};

/// The members of an object of run.json. Each function throws Error, with the file, where the member is missing or
/// is something else.
class Members {
 public:
  Members(const std::filesystem::path& file, const json& object) : file_(file), object_(object) {}

  void value(const char* key, std::string& value) const { value = of(key, &json::is_string, "a text"); }
  /// NaN where it is null.
  void value(const char* key, double& value, Null null = Null::no) const {
    const auto found = object_.find(key);
    const bool is_none =
        found == object_.end() ? null == Null::or_missing : found->is_null() && null != Null::no;
    value = is_none ? std::numeric_limits<double>::quiet_NaN()
                    : of(key, &json::is_number, "a number").get<double>();
  }
  void value(const char* key, std::uint64_t& value) const {
    value = of(key, &json::is_number_unsigned, "a whole number from 0");
  }
  void value(const char* key, std::vector<std::pair<std::string, std::string>>& pairs) const {
    for (const json& pair : of(key, &json::is_array, "a list")) {
      if (!pair.is_array() || pair.size() != 2 || !pair[0].is_string() || !pair[1].is_string())
        refuse(key, pair, "pairs of texts");
      pairs.emplace_back(pair[0], pair[1]);
    }
  }
  template <class T>
  void list(const char* key, std::vector<T>& values) const {
    for (const json& element : of(key, &json::is_array, "a list")) {
      if (!element.is_object()) refuse(key, element, "a list of objects");
      const Members members(file_, element);
      visit(members, values.emplace_back());
    }
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
  json object = Written(info).object;
  object["hystcan_run"] = format_version;
  return object;
}

RunInfo read_run_info(const std::filesystem::path& run) {
  const std::filesystem::path file = run / info_name;
  try {
    const json object = parsed(file, read_regular_file(file, largest_info));
    const Members info(file, object);
    std::uint64_t version = 0;
    info.value("hystcan_run", version);
    if (version != format_version)
      throw Error(fmt::format("{}: hystcan_run is {}, expected {}: made by another version of hystcan",
                              file.string(), version, format_version));
    RunInfo result;
    visit(info, result);
    return result;
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
