#include "config/document/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "base/input_file.h"
#include "base/text.h"
#include "config/document/closest.h"
#include "config/document/format.h"
#include "config/document/toml_text.h"

namespace hystcan::config {
namespace {

std::string place(const std::filesystem::path& file, const toml::source_position& position) {
  return fmt::format("{}:{}:{}", file.string(), position.line, position.column);
}

std::string join_choices(std::span<const std::string_view> choices) {
  return fmt::format("\"{}\"", fmt::join(choices, "\", \""));
}

std::string meant_instead_of(std::string_view key, const std::set<std::string, std::less<>>& known) {
  const auto meant = meant_by(key, {known.begin(), known.end()});
  return meant ? fmt::format(" (did you mean {}?)", *meant) : std::string();
}

}  // namespace

Document::Document(std::filesystem::path file, std::string_view text)
    : file_(std::move(file)), root_(parse_toml(text, file_.string())) {
  take_format();
}

Document::Document(std::filesystem::path file, const std::vector<Setting>& overrides, std::size_t largest)
    : file_(std::move(file)) {
  try {
    root_ = parse_toml(read_regular_file(file_, largest), file_.string());
  } catch (const FileError& error) {
    throw Error(fmt::format("{}: cannot be read: {}, expected a TOML file", file_.string(), error.what()));
  }
  take_format();
  for (const Setting& setting : overrides) put(setting);
}

void Document::take_format() {
  require_known_format(root_, file_.string());
  root_.erase("format");
}

/// Creates missing tables on the path to the key, but no elements of a list.
void Document::put(const Setting& setting) {
  const std::size_t dot = setting.path.rfind('.');
  const std::string key = dot == std::string::npos ? setting.path : setting.path.substr(dot + 1);
  const std::string above = dot == std::string::npos ? std::string() : setting.path.substr(0, dot);
  toml::table parsed;
  try {
    parsed = parse_toml("value = " + setting.value + "\n", setting.path, setting.path);
  } catch (const Error&) {
    throw Error(fmt::format("{} = {}: not a value, expected one as in TOML", setting.path, setting.value));
  }
  if (!above.empty() && !root_.at_path(above)) put({above, "{}"});
  toml::table* table = above.empty() ? &root_ : root_.at_path(above).as_table();
  if (table == nullptr || key.find('[') != std::string::npos || parsed.size() != 1)
    throw Error(
        fmt::format("{}: there is no such key to set, expected one of the configuration", setting.path));
  toml::node& value = *parsed.get("value");
  const toml::source_region origin = value.source();
  table->insert_or_assign(toml::key(key, toml::source_region(origin)), std::move(value));
}

std::filesystem::path Document::resolve(const std::filesystem::path& path) const {
  return file_.parent_path() / path;
}

void Document::fail(const toml::source_region& where, const std::string& what) const {
  if (where.path)
    throw Error(fmt::format("{}: {}", *where.path, what));  // it stands in an override, not in the file
  const toml::source_position position = where.begin ? where.begin : toml::source_position{1, 1};
  throw Error(fmt::format("{}: {}", place(file_, position), what));
}

void Document::fail_at(std::string_view path, const std::string& what) const {
  while (true) {
    if (const auto node = root_.at_path(path)) fail(node.node()->source(), what);
    const auto cut = path.find_last_of(".[");
    if (cut == std::string_view::npos) fail(root_.source(), what);
    path = path.substr(0, cut);
  }
}

std::string Range::describe() const {
  if (std::isinf(lo) && std::isinf(hi)) return "a finite number";
  const char* above = lo_excluded ? ">" : ">=";
  if (std::isinf(hi)) return fmt::format("a number {} {}", above, lo);
  if (std::isinf(lo)) return fmt::format("a number <= {}", hi);
  return fmt::format("a number {} {} and <= {}", above, lo, hi);
}

double nanoseconds_per_unit(std::string_view key) {
  if (key.ends_with("_us")) return 1e3;
  if (key.ends_with("_ms")) return 1e6;
  return 1e9;
}

void Reader::choice(std::string_view key, std::string& value, std::span<const std::string_view> choices,
                    const About& /*about*/) {
  required(key, value);
  lacks_choice_ |= !table_.contains(key);
  if (table_.contains(key) && std::ranges::find(choices, value) == choices.end())
    document_.fail(table_.get(key)->source(),
                   fmt::format("{} is \"{}\", expected one of {}", key, value, join_choices(choices)));
}

void Reader::numbers(std::string_view key, std::vector<double>& values, const About& /*about*/) {
  known_.emplace(key);
  const toml::node* node = table_.get(key);
  if (node != nullptr && node->is_array() && node->as_array()->empty())
    values.clear();
  else if (node != nullptr)
    values = read_numbers(*node, key, any);
}

void Reader::limit_or_inf(std::string_view key, double& value, double /*in_its_place*/,
                          const About& /*about*/) {
  known_.emplace(key);
  const toml::node* node = table_.get(key);
  if (node != nullptr && node->value<double>() != std::numeric_limits<double>::infinity())
    read(*node, key, value, positive);
}

bool Reader::read_choices(std::string_view key, std::vector<std::string>& values,
                          std::span<const std::string_view> choices) {
  known_.emplace(key);
  const toml::node* node = table_.get(key);
  if (node == nullptr) return false;
  const toml::array* array = node->as_array();
  if (array == nullptr) wrong_type(*node, key, "an array of words");
  values.reserve(array->size());
  for (const toml::node& element : *array) {
    values.push_back(read_string(element, key));
    if (std::ranges::find(choices, values.back()) == choices.end())
      document_.fail(element.source(), fmt::format("{} has \"{}\", expected some of {}", key, values.back(),
                                                   join_choices(choices)));
  }
  return true;
}

void Reader::whole_numbers(std::string_view key, std::vector<std::int64_t>& values, const About& /*about*/) {
  known_.emplace(key);
  const toml::node* node = table_.get(key);
  if (node == nullptr) return;
  const toml::array* array = node->as_array();
  if (array == nullptr) wrong_type(*node, key, "an array of whole numbers");
  values.clear();
  values.reserve(array->size());
  for (const toml::node& element : *array) {
    const auto value = element.value_exact<std::int64_t>();
    if (!value) wrong_type(element, key, "a whole number");
    values.push_back(*value);
  }
}

void Reader::finish() const {
  for (const auto& [key, node] : table_) {
    if (known_.contains(key.str())) continue;
    const std::string meant = meant_instead_of(key.str(), known_);
    if (lacks_choice_ && meant.empty()) continue;
    document_.fail(key.source(), fmt::format("unknown key {}{}, expected one of {}", key.str(), meant,
                                             fmt::join(known_, ", ")));
  }
  if (!missing_.empty())
    document_.fail(table_.source(), fmt::format("missing key {}, expected in {}", missing_,
                                                path_.empty() ? "the file" : "[" + path_ + "]"));
}

bool Reader::read_bool(const toml::node& node, std::string_view key) const {
  const auto value = node.value_exact<bool>();
  if (!value) wrong_type(node, key, "true or false");
  return *value;
}

std::int64_t Reader::read_integer(const toml::node& node, std::string_view key, Range range,
                                  double type_max) const {
  range.lo = std::max(range.lo, 0.0);
  range.hi = std::min(range.hi, type_max);
  const auto value = node.value_exact<std::int64_t>();
  if (!value) wrong_type(node, key, "a whole number");
  if (!range.contains(static_cast<double>(*value)))
    document_.fail(node.source(), fmt::format("{} is {}, expected {}", key, *value, range.describe()));
  return *value;
}

double Reader::read_number(const toml::node& node, std::string_view key, Range range) const {
  if (!node.is_number()) wrong_type(node, key, range.describe());
  // value<double>() is empty for an integer that no double is equal to.
  const double value =  // + 0.0: of -0.0 nothing but its sign would be left, in margins and in messages
      (node.is_integer() ? static_cast<double>(**node.as_integer()) : **node.as_floating_point()) + 0.0;
  if (!std::isfinite(value) || !range.contains(value))
    document_.fail(node.source(), fmt::format("{} is {}, expected {}", key, value, range.describe()));
  return value;
}

can::Duration Reader::read_duration(const toml::node& node, std::string_view key, Range range) const {
  constexpr double year_ns = 365.0 * 86'400.0 * 1e9;
  const double value = read_number(node, key, range), unit_ns = nanoseconds_per_unit(key);
  if (std::abs(value) > year_ns / unit_ns)
    document_.fail(node.source(),
                   fmt::format("{} is {}, expected at most a year, {}", key, value, year_ns / unit_ns));
  const can::Duration duration(std::llround(value * unit_ns));
  if (value != 0.0 && duration == can::Duration::zero())
    document_.fail(node.source(),
                   fmt::format("{} is {}, expected at least a nanosecond, {}", key, value, 1.0 / unit_ns));
  return duration;
}

std::vector<double> Reader::read_numbers(const toml::node& node, std::string_view key, Range range) const {
  const toml::array* array = node.as_array();
  if (array == nullptr) wrong_type(node, key, "an array of numbers");
  if (array->empty())
    document_.fail(node.source(), fmt::format("{} is empty, expected at least one number", key));
  std::vector<double> values;
  for (const toml::node& element : *array) values.push_back(read_number(element, key, range));
  return values;
}

std::string Reader::read_string(const toml::node& node, std::string_view key) const {
  const auto value = node.value_exact<std::string>();
  if (!value) wrong_type(node, key, "a string");
  if (value->empty()) document_.fail(node.source(), fmt::format("{} is empty, expected text", key));
  if (has_control_character(*value))
    document_.fail(node.source(), fmt::format("{} has a control character, expected text of one line", key));
  return *value;
}

const toml::node* Reader::look_up(std::string_view key) {
  known_.emplace(key);
  const toml::node* node = table_.get(key);
  if (node == nullptr && missing_.empty()) missing_ = key;
  return node;
}

void Reader::wrong_type(const toml::node& node, std::string_view key, const std::string& expected) const {
  std::ostringstream type;
  type << node.type();
  document_.fail(node.source(), fmt::format("{} is of type {}, expected {}", key, type.str(), expected));
}

std::string Reader::join(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void Writer::line(std::string_view key, const std::string& value, bool is_required, const About& about,
                  std::span<const std::string_view> choices, Range range) {
  const std::string path = path_.empty() ? std::string(key) : path_ + "." + std::string(key);
  const auto comment = remark_({{path, value}, range, about.meaning, choices}, is_required);
  if (!comment) return;
  if (layout_ == Layout::model) {
    keys_ += fmt::format("{:<12} = {}{}{}\n", key, value, about.meaning.empty() ? "" : "  # ", about.meaning);
    return;
  }
  const std::string text =
      layout_ == Layout::plain ? fmt::format("{} = {}", key, value) : fmt::format("{:<22} = {}", key, value);
  if (comment->empty())
    keys_ += text + "\n";
  else if (layout_ == Layout::plain)
    keys_ += fmt::format("{}  # {}\n", text, *comment);
  else
    keys_ += fmt::format("{:<34} # {}\n", text, *comment);
}

/// In columns a table without keys of its own has no header; tables within it imply it.
void Writer::enter(std::string_view key, const std::string& index, const std::function<void(Writer&)>& body) {
  Writer inner(layout_, remark_);
  inner.header_ = header_.empty() ? std::string(key) : header_ + "." + std::string(key);
  inner.path_ = (path_.empty() ? std::string(key) : path_ + "." + std::string(key)) + index;
  body(inner);
  if (layout_ == Layout::plain || !inner.keys_.empty()) {
    const std::string name = "[" + inner.header_ + "]", header = index.empty() ? name : "[" + name + "]";
    const std::string comment = remark_({{inner.path_, {}}}, false).value_or("");
    tables_ += '\n' + (comment.empty() ? header : fmt::format("{:<34} # {}", header, comment)) + '\n';
  }
  tables_ += inner.text();
}

void Writer::limit_or_inf(std::string_view key, double value, double in_its_place, const About& about) {
  if (!std::isfinite(in_its_place) || layout_ == Layout::schema)
    line(key, number(value), false, about, {}, positive);
  else if (layout_ == Layout::plain)
    keys_ += fmt::format("# {} = {:.6g}  # default, of transitions alone\n", key, in_its_place);
}

void Writer::whole_numbers(std::string_view key, const std::vector<std::int64_t>& values,
                           const About& about) {
  line(key, fmt::format("[{}]", fmt::join(values, ", ")), false, about);
}

std::string Writer::number(double value, int digits) const {
  if (layout_ == Layout::model) return fmt::format("{:.{}g}", value, digits);
  std::string text = fmt::format("{}", value);
  const bool is_whole = std::isfinite(value) && text.find_first_of(".e") == std::string::npos;
  return is_whole && layout_ == Layout::columns ? text + ".0" : text;
}

std::string Writer::list_of(const std::vector<double>& values) const {
  std::vector<std::string> texts;
  texts.reserve(values.size());
  for (const double value : values) texts.push_back(number(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string Writer::list_of(const std::vector<std::string_view>& words) {
  return fmt::format("[{}]", join_choices(words));
}

}  // namespace hystcan::config
