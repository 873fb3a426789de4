#include "config/document/document.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

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

std::string join_choices(std::span<const std::string_view> choices) {
  return fmt::format("\"{}\"", fmt::join(choices, "\", \""));
}

std::string type_of(const toml::node& node) {
  std::ostringstream type;
  type << node.type();
  return type.str();
}

}  // namespace

/// Parses the text. Removes the key `format` from the root table, because it is the version of the file
/// format and not a key of the configuration.
Document::Document(std::filesystem::path file, std::string_view text) : file_(std::move(file)) {
  toml::table root = parse_toml(text, file_.string());
  require_known_format(root, file_.string());
  root.erase("format");
  root_ = read_ = std::make_shared<const toml::table>(std::move(root));
}

Document::Document(const std::filesystem::path& file, std::size_t largest)
    : Document(file, read_regular_file(file, largest, a_toml_file)) {}

Document Document::with(const std::vector<Setting>& overrides) const {
  Document changed = *this;
  if (overrides.empty()) return changed;
  toml::table root = *root_;
  for (const Setting& setting : overrides) changed.put(setting, root);
  changed.root_ = std::make_shared<const toml::table>(std::move(root));
  return changed;
}

/// Sets the value of the setting's key in `root`. Creates missing tables on the path of the key, but no
/// missing elements of lists.
void Document::put(const Setting& setting, toml::table& root) {
  const std::size_t dot = setting.path.rfind('.');
  const std::string key = dot == std::string::npos ? setting.path : setting.path.substr(dot + 1);
  const std::string above = dot == std::string::npos ? std::string() : setting.path.substr(0, dot);
  toml::table parsed;
  try {
    parsed = parse_toml("value = " + setting.value + "\n", setting.path, setting.path);
  } catch (const Error&) {
    throw Error(fmt::format("{} = {}: not a TOML value", setting.path, setting.value),
                expect("for example 1.5, true or \"text\""));
  }
  if (!above.empty() && !root.at_path(above)) put({above, "{}"}, root);
  toml::table* table = above.empty() ? &root : root.at_path(above).as_table();
  if (table == nullptr || key.find('[') != std::string::npos || parsed.size() != 1)
    throw Error(setting.path, "unknown key", expect("a key of the configuration"));
  toml::node& value = *parsed.get("value");
  const toml::source_region origin = value.source();
  table->insert_or_assign(toml::key(key, toml::source_region(origin)), std::move(value));
  overridden_.push_back(setting.path);
}

std::filesystem::path Document::resolve(const std::filesystem::path& path) const {
  return file_.parent_path() / path;
}

Place Document::place_of(const toml::source_region& where) const {
  if (where.path) return *where.path;  // an override, not the file, sets this value
  const toml::source_position position = where.begin ? where.begin : toml::source_position{1, 1};
  return {file_, position.line, position.column};
}

Place Document::place_at(std::string_view path) const {
  while (!path.empty() && !has(path)) {
    const auto cut = path.find_last_of(".[");
    path = path.substr(0, cut == std::string_view::npos ? 0 : cut);
  }
  const auto override = std::find_if(overridden_.rbegin(), overridden_.rend(),
                                     [&](const std::string& of) { return is_within(path, of); });
  if (override != overridden_.rend()) return *override;
  return place_of(path.empty() ? read_->source() : read_->at_path(path).node()->source());
}

std::string Range::describe() const {
  if (std::isinf(lo) && std::isinf(hi)) return "a finite number";
  const char* above = lo_excluded ? ">" : ">=";
  if (std::isinf(hi)) return fmt::format("a number {} {}", above, lo);
  if (std::isinf(lo)) return fmt::format("a number <= {}", hi);
  return fmt::format("a number {}{} {} and <= {}", either_sign ? "whose magnitude is " : "", above, lo, hi);
}

std::string unit_of(std::string_view key) {
  constexpr std::pair<std::string_view, std::string_view> units[] = {
      {"um", "um"},   {"s", "s"},   {"ms", "ms"},  {"us", "us"},        {"hour", "h"},    {"h", "h"},
      {"Hz", "Hz"},   {"V", "V"},   {"A", "A"},    {"K", "K"},          {"percent", "%"}, {"deg", "deg"},
      {"ppm", "ppm"}, {"MB", "MB"}, {"GB", "GB"},  {"uF", "uF"},        {"mH", "mH"},     {"ohm", "ohm"},
      {"bit", "bit"}, {"<U>", "U"}, {"s2", "s^2"}, {"rtHz", "sqrt(Hz)"}};
  key.remove_prefix(key.rfind('.') + 1);  // without a '.', rfind() + 1 is 0
  if (key == "kp") return "um/um";
  if (key.ends_with("_rms")) key.remove_suffix(4);
  const auto unit_at_end = [&](std::string_view text) {
    const std::string_view word = text.substr(text.rfind('_') + 1);
    const auto found = std::ranges::find(units, word, [](const auto& unit) { return unit.first; });
    return found == std::end(units) ? std::string() : std::string(found->second);
  };
  std::string unit = unit_at_end(key);
  const std::size_t per = key.rfind("_per_");
  if (unit.empty() || per == std::string_view::npos || key.find('_', per + 5) != std::string_view::npos)
    return unit;
  const std::string above = unit_at_end(key.substr(0, per));
  return (above.empty() ? "1" : above) + "/" + unit;
}

bool is_within(std::string_view path, std::string_view table) {
  return path.starts_with(table) &&
         (path.size() == table.size() || path[table.size()] == '.' || path[table.size()] == '[');
}

double nanoseconds_per_unit(std::string_view key) {
  if (key.ends_with("_us")) return 1e3;
  if (key.ends_with("_ms")) return 1e6;
  return 1e9;
}

void Reader::choice(std::string_view key, std::string& value, std::span<const std::string_view> choices,
                    const About& /*about*/) {
  lacks_choice_ |= !table_.contains(key);
  if (const toml::node* node = look_up(key)) value = read_word(*node, key, choices);
}

void Reader::limit_or_inf(std::string_view key, double& value, double /*in_its_place*/,
                          const About& /*about*/) {
  known_.emplace(key);
  const toml::node* node = table_.get(key);
  if (node != nullptr && node->value<double>() != std::numeric_limits<double>::infinity())
    read(*node, key, value, positive);
}

void Reader::finish() const {
  for (const auto& [key, node] : table_) {
    if (known_.contains(key.str())) continue;
    const auto suggestion = meant_by(key.str(), {known_.begin(), known_.end()});
    if (lacks_choice_ && !suggestion) continue;
    throw Error(document_.place_of(key.source()),
                fmt::format("unknown key {}{}", key.str(),
                            suggestion ? fmt::format(" (did you mean {}?)", *suggestion) : ""),
                expect("one of {}", fmt::join(known_, ", ")));
  }
  if (!missing_.empty())
    document_.fail_at(path_, fmt::format("missing key {}, expected in {}", missing_,
                                         path_.empty() ? "the file" : "[" + path_ + "]"));
}

const toml::table& Reader::table_at(const toml::node& node, const std::string& path) const {
  if (const toml::table* table = node.as_table()) return *table;
  document_.fail_at(path, fmt::format("{} is of type {}, expected a table", path, type_of(node)));
}

bool Reader::read_bool(const toml::node& node, std::string_view key) const {
  const auto value = node.value_exact<bool>();
  if (!value) wrong_type(node, key, "true or false");
  return *value;
}

std::int64_t Reader::read_whole_number(const toml::node& node, std::string_view key, Index index) const {
  const auto value = node.value_exact<std::int64_t>();
  if (!value) wrong_type(node, key, "a whole number", index);
  return *value;
}

std::int64_t Reader::read_integer(const toml::node& node, std::string_view key, Range range,
                                  double type_max) const {
  range.lo = std::max(range.lo, 0.0);
  range.hi = std::min(range.hi, type_max);
  const std::int64_t value = read_whole_number(node, key);
  if (!range.contains(static_cast<double>(value)))
    fail(key, fmt::format("is {}, expected {}", value, range.describe()));
  return value;
}

double Reader::read_number(const toml::node& node, std::string_view key, Range range, Index index) const {
  if (!node.is_number()) wrong_type(node, key, range.describe(), index);
  // node.value<double>() would be empty for an integer that no double represents exactly.
  const double value =  // "+ 0.0" turns -0.0 into 0.0; messages would show "-0"
      (node.is_integer() ? static_cast<double>(**node.as_integer()) : **node.as_floating_point()) + 0.0;
  if (!std::isfinite(value) || !range.contains(value))
    fail(key, fmt::format("is {}, expected {}", value, range.describe()), index);
  return value;
}

can::Duration Reader::read_duration(const toml::node& node, std::string_view key, Range range) const {
  constexpr double year_ns = 365.0 * 86'400.0 * 1e9;
  const double value = read_number(node, key, range), unit_ns = nanoseconds_per_unit(key);
  if (std::abs(value) > year_ns / unit_ns)
    fail(key, fmt::format("is {}, expected at most a year, {}", value, year_ns / unit_ns));
  const can::Duration duration(std::llround(value * unit_ns));
  if (value != 0.0 && duration == can::Duration::zero())
    fail(key, fmt::format("is {}, expected at least a nanosecond, {}", value, 1.0 / unit_ns));
  return duration;
}

std::string Reader::read_string(const toml::node& node, std::string_view key, Index index) const {
  const auto value = node.value_exact<std::string>();
  if (!value) wrong_type(node, key, "a string", index);
  if (value->empty()) fail(key, "is empty, expected text", index);
  if (has_control_character(*value))
    fail(key, "contains a control character, expected one line of text", index);
  return *value;
}

std::string Reader::read_word(const toml::node& node, std::string_view key,
                              std::span<const std::string_view> choices, Index index) const {
  std::string word = read_string(node, key, index);
  const char *is = index ? "has" : "is", *one = index ? "some" : "one";
  if (std::ranges::find(choices, word) == choices.end())
    fail(key, fmt::format("{} \"{}\", expected {} of {}", is, word, one, join_choices(choices)), index);
  return word;
}

const toml::node* Reader::look_up(std::string_view key) {
  known_.emplace(key);
  const toml::node* node = table_.get(key);
  if (node == nullptr && missing_.empty()) missing_ = key;
  return node;
}

void Reader::fail(std::string_view key, const std::string& what, Index index) const {
  document_.fail_at(index ? fmt::format("{}[{}]", join(key), *index) : join(key),
                    fmt::format("{} {}", key, what));
}

void Reader::wrong_type(const toml::node& node, std::string_view key, const std::string& expected,
                        Index index) const {
  fail(key, fmt::format("is of type {}, expected {}", type_of(node), expected), index);
}

std::string Reader::join(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void Writer::line(std::string_view key, const Member& member, const std::string& value, bool is_required,
                  const About& about, std::span<const std::string_view> choices, Range range) {
  const std::string path = path_.empty() ? std::string(key) : path_ + "." + std::string(key);
  const Setting setting{path, value, about.effect.value_or(effect_)};
  const auto comment = remark_({setting, range, about.meaning, choices, member}, is_required);
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

/// Writes a table. A table without keys of its own gets a header only in the layout `plain`; in other layouts
/// the headers of its sub-tables imply the table.
void Writer::enter(std::string_view key, const std::string& index, const Member& member,
                   const std::function<void(Writer&)>& body) {
  Writer inner(layout_, remark_);
  inner.effect_ = effect_;
  inner.header_ = header_.empty() ? std::string(key) : header_ + "." + std::string(key);
  inner.path_ = (path_.empty() ? std::string(key) : path_ + "." + std::string(key)) + index;
  Key table{{inner.path_, {}}};
  table.member = member;
  table.is_table = true;
  const std::string comment = remark_(table, false).value_or("");
  body(inner);
  if (layout_ == Layout::plain || !inner.keys_.empty()) {
    const std::string name = "[" + inner.header_ + "]", header = index.empty() ? name : "[" + name + "]";
    tables_ += '\n' + (comment.empty() ? header : fmt::format("{:<34} # {}", header, comment)) + '\n';
  }
  tables_ += inner.text();
}

void Writer::limit_or_inf(std::string_view key, const double& value, double in_its_place,
                          const About& about) {
  if (!std::isfinite(in_its_place) || layout_ == Layout::schema)
    line(key, value, text_of(key, value), false, about, {}, positive);
  else if (layout_ == Layout::plain)
    keys_ += fmt::format("# {} = {:.6g}  # default, applies only to transitions\n", key, in_its_place);
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

std::string Writer::list_of(const std::vector<std::int64_t>& values) {
  return fmt::format("[{}]", fmt::join(values, ", "));
}

std::string Writer::list_of(const std::vector<std::string_view>& words) {
  return fmt::format("[{}]", join_choices(words));
}

}  // namespace hystcan::config
