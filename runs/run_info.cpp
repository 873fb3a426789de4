#include "runs/run_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <fstream>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "base/error.h"
#include "base/input_file.h"
#include "base/output_file.h"

namespace hystcan::runs {
namespace {

using nlohmann::json;

constexpr std::uint64_t format_version = 1;
constexpr std::size_t largest_info = 64 << 20;

// The functions visit() list the members of run.json. Writing and reading use the same lists. The visitor's
// measured() is for a number that may be null (NaN), and added() is for a member that older runs lack.

template <class Visitor, class Fault>
requires std::same_as<std::remove_const_t<Fault>, RunFault>
void visit(const Visitor& member, Fault& fault) {
  member("cause", fault.cause);
  member("time_s", fault.time_s);
}

template <class Visitor, class Axis>
requires std::same_as<std::remove_const_t<Axis>, RunAxis>
void visit(const Visitor& member, Axis& axis) {
  member("name", axis.name);
  member("drive_unit", axis.drive_unit);
  member("stroke_um", axis.stroke_um);
  member.added("delay_s", axis.delay_s);
  member("tracked_rows", axis.tracked_rows);
  member.measured("error_rms_um", axis.rms_um);
  member.measured("error_max_um", axis.max_um);
  member("faults", axis.faults);
}

template <class Visitor, class Info>
requires std::same_as<std::remove_const_t<Info>, RunInfo>
void visit(const Visitor& member, Info& info) {
  member("version", info.version);
  member("host", info.host);
  member("command", info.command);
  member("config", info.config);
  member("interface", info.interface);
  member("rate_Hz", info.rate_Hz);
  member("started", info.started);
  member("ended", info.ended);
  member("failure", info.failure);
  member("first_s", info.first_s);
  member("last_s", info.last_s);
  member("rows", info.rows);
  member("rows_lost", info.rows_lost);
  member("settings", info.settings);
  member("axes", info.axes);
}

class Writer {
 public:
  explicit Writer(json& object) : object_(object) {}

  template <class Value>
  void operator()(const char* key, const Value& value) const {
    object_[key] = value;
  }
  template <class Object>
  requires requires(const Writer& writer, const Object& object) { visit(writer, object); }
  void operator()(const char* key, const std::vector<Object>& objects) const {
    json list = json::array();
    for (const Object& object : objects) visit(Writer(list.emplace_back(json::object())), object);
    object_[key] = std::move(list);
  }
  void measured(const char* key, double value) const { object_[key] = value; }
  void added(const char* key, double value) const { object_[key] = value; }

 private:
  json& object_;
};

/// Visitor that reads the members of a JSON object. Throws Error with the file's name if a member is missing
/// or has a wrong type.
class Reader {
 public:
  Reader(const std::filesystem::path& file, const json& object) : file_(file), object_(object) {}

  void operator()(const char* key, std::string& text) const { text = of(key, &json::is_string, "a text"); }
  void operator()(const char* key, double& number) const { number = of(key, &json::is_number, "a number"); }
  void operator()(const char* key, std::uint64_t& count) const {
    count = of(key, &json::is_number_unsigned, "a whole number, 0 or more");
  }
  void operator()(const char* key, std::vector<std::pair<std::string, std::string>>& pairs) const {
    for (const json& pair : of(key, &json::is_array, "a list")) {
      if (!pair.is_array() || pair.size() != 2 || !pair[0].is_string() || !pair[1].is_string())
        refuse(key, pair, "pairs of texts");
      pairs.emplace_back(pair[0], pair[1]);
    }
  }
  template <class Object>
  void operator()(const char* key, std::vector<Object>& objects) const {
    for (const json& element : of(key, &json::is_array, "a list")) {
      if (!element.is_object()) refuse(key, element, "a list of objects");
      visit(Reader(file_, element), objects.emplace_back());
    }
  }
  void measured(const char* key, double& number) const {
    const auto found = object_.find(key);
    if (found == object_.end() || !found->is_null()) return (*this)(key, number);
    number = std::numeric_limits<double>::quiet_NaN();
  }
  void added(const char* key, double& number) const {
    if (object_.contains(key)) measured(key, number);
  }

 private:
  const json& of(const char* key, bool (json::*is_right)() const noexcept, const char* expected) const {
    const auto found = object_.find(key);
    if (found == object_.end()) throw Error(file_, fmt::format("{} is missing", key), {.expected = expected});
    if (!((*found).*is_right)()) refuse(key, *found, expected);
    return *found;
  }
  [[noreturn]] void refuse(const char* key, const json& found, const char* expected) const {
    constexpr std::size_t longest = 40;
    const std::string text =  // dump() is recursive, so a deeply nested value could overflow the stack
        found.is_structured() ? found.type_name() : found.dump(-1, ' ', true, json::error_handler_t::replace);
    throw Error(file_,
                fmt::format("{} is {}{}", key, text.substr(0, longest), text.size() > longest ? "..." : ""),
                {.expected = expected});
  }

  const std::filesystem::path& file_;
  const json& object_;
};

json parsed(const std::filesystem::path& file, const std::string& text) {
  std::string what;
  try {
    json info = json::parse(text);
    if (info.is_object()) return info;
    what = "not a JSON object";
  } catch (const json::parse_error& error) {
    what = fmt::format("invalid JSON at byte {}", error.byte);
  } catch (const json::out_of_range&) {  // for example the number 1e999
    what = "a number that is too large";
  }
  throw Error(file, what, expect("a file that hystcan wrote"));
}

}  // namespace

std::vector<std::string> RunInfo::axis_names() const {
  std::vector<std::string> names;
  for (const RunAxis& axis : axes) names.push_back(axis.name);
  return names;
}

json to_json(const RunInfo& info) {
  json object{{"hystcan_run", format_version}};
  visit(Writer(object), info);
  return object;
}

RunInfo read_run_info(const std::filesystem::path& run) {
  const std::filesystem::path file = run / info_name;
  const json object = parsed(file, read_regular_file(file, largest_info, "a run's folder"));
  const Reader reader(file, object);
  std::uint64_t version = 0;
  reader("hystcan_run", version);
  if (version != format_version)
    throw Error(file, fmt::format("hystcan_run is {}", version),
                expect("{}: another version of hystcan wrote the run", format_version));
  RunInfo info;
  visit(reader, info);
  return info;
}

bool ended_without_fault(const std::filesystem::path& run) {
  std::error_code ignored;
  // file_size() returns the maximum of its type if the file is missing, so a missing file returns false, too.
  if (std::filesystem::file_size(run / info_name, ignored) > largest_info) return false;
  std::ifstream stream(run / info_name);
  const json info = json::parse(stream, nullptr, false);
  const auto axes = info.find("axes");
  return axes != info.end() && axes->is_array() && std::ranges::all_of(*axes, [](const json& axis) {
           const auto faults = axis.find("faults");
           return faults != axis.end() && faults->is_array() && faults->empty();
         });
}

void write_run_info(const std::filesystem::path& run, const RunInfo& info) {
  OutputFile file(run / info_name, OutputFile::Kind::durable);
  file.write(to_json(info).dump(2, ' ', false, json::error_handler_t::replace) + "\n");
  file.commit();
}

}  // namespace hystcan::runs
