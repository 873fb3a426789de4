// The key tables of docs/configuration/*.md match the program. They are between the lines
//
//   <!-- keys: [axis.control] from kp to ki_per_s -->      or without `from ... to ...`: the whole table
//   <!-- end -->
//
// If HYSTCAN_WRITE_KEY_TABLES=1 is in the environment, the test writes them.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>

#include "config/schema/config.h"
#include "config/schema/schema.h"
#include "config/schema/settings.h"

namespace hystcan::config::key_tables_test {
namespace {

struct Row {
  std::string key, range, otherwise, meaning;
  bool operator==(const Row&) const = default;
};
using Tables = std::map<std::string, std::vector<Row>>;  ///< by header: "[bus]", "[[axis]]"

std::string in_words(std::span<const std::string_view> words) {
  constexpr std::size_t most = 10;
  return words.size() > most ? std::string() : fmt::format("`{}`", fmt::join(words, "`, `"));
}

template <class T>
std::string range_text(Range range) {
  if constexpr (std::is_same_v<T, bool>) {
    return "`true`, `false`";
  } else if constexpr (HasWords<T>) {
    return in_words(words(T{}));
  } else if constexpr (std::is_convertible_v<T, std::filesystem::path>) {
    return {};
  } else if constexpr (std::is_integral_v<T>) {
    range.lo = std::max(range.lo, 0.0);
    if constexpr (sizeof(T) < sizeof(std::uint64_t))
      range.hi = std::min(range.hi, static_cast<double>(std::numeric_limits<T>::max()));
  }
  const bool has_lo = std::isfinite(range.lo), has_hi = std::isfinite(range.hi);
  if (has_lo && has_hi && !range.lo_excluded)
    return fmt::format("{}{}..{}", range.either_sign ? "±" : "", range.lo, range.hi);
  std::string text;
  if (has_lo) text = fmt::format("{} {}", range.lo_excluded ? ">" : ">=", range.lo);
  if (has_hi) text += fmt::format("{}<= {}", has_lo ? ", " : "", range.hi);
  return text;
}

template <class T>
std::string default_text(std::string_view key, const T& value) {
  if constexpr (std::is_same_v<T, bool>)
    return value ? "`true`" : "`false`";
  else if constexpr (std::is_same_v<T, can::Duration>)
    return fmt::format("{}", static_cast<double>(value.count()) / nanoseconds_per_unit(key));
  else if constexpr (std::is_arithmetic_v<T>)
    return fmt::format("{}", value);
  else if constexpr (HasWords<T>)
    return fmt::format("`\"{}\"`", word_of(value));
  else if constexpr (ListOfWords<T>)
    return "none";
  else if constexpr (std::is_same_v<T, std::vector<double>> || std::is_same_v<T, std::vector<std::int64_t>>)
    return value.empty() ? "none" : fmt::format("`[{}]`", fmt::join(value, ", "));
  else
    return value.empty() ? "none" : fmt::format("`\"{}\"`", std::filesystem::path(value).string());
}

/// Sets the values that make further keys appear.
template <class T>
void open_further_keys(std::string_view key, T& value) {
  if constexpr (std::is_same_v<T, bool>) value = value && key != "both_directions";
  if constexpr (std::is_same_v<T, can::DataId::Kind>) value = can::DataId::Kind::number;
  if constexpr (std::is_same_v<T, twin::Fault>) value = twin::Fault::late;
  if constexpr (std::is_same_v<T, std::string>)
    if (value.empty()) value = "named";
}

/// Records all keys, with the defaults of the structs.
class Describer {
 public:
  Describer(Tables& tables, std::string name, bool is_list)
      : tables_(tables), name_(std::move(name)), header_(is_list ? "[[" + name_ + "]]" : "[" + name_ + "]") {}

  template <class T>
  void required(std::string_view key, T& value, Range range = any, const About& about = {}) {
    add(key, range_text<T>(range), "required", about);
    open_further_keys(key, value);
  }
  template <class T>
  void optional(std::string_view key, T& value, Range range = any, const About& about = {}) {
    add(key, range_text<T>(range), default_text(key, value), about);
    open_further_keys(key, value);
  }
  void choice(std::string_view key, std::string&, std::span<const std::string_view> choices,
              const About& about = {}) {
    add(key, in_words(choices), "required", about);
  }
  void limit_or_inf(std::string_view key, double&, double, const About& about = {}) {
    add(key, "> 0, or `inf`", "none", about);
  }
  template <class T, class Visit>
  void table(std::string_view key, T& value, Visit visit) {
    Describer sub(tables_, join(key), false);
    visit(sub, value);
  }
  template <class T, class Visit>
  void section(std::string_view key, T& value, Visit visit) {
    table(key, value, visit);
  }
  template <class T, class Visit>
  void optional_table(std::string_view key, std::optional<T>&, Visit visit) {
    T value{};
    table(key, value, visit);
  }
  template <class T, class Visit>
  void list(std::string_view key, std::vector<T>&, Visit visit) {
    Describer sub(tables_, join(key), true);
    if constexpr (std::is_same_v<T, controller::Segment>) {
      for (const std::string_view kind : controller::shape_kinds) {
        Tables of_kind;
        T segment{.shape = controller::shape_of_kind(kind)};
        Describer described(of_kind, join(key), true);
        visit(described, segment);
        std::vector<Row>& rows = of_kind.at(sub.header_);
        const auto own = rows.begin() + 2;  // after the kind and the transition
        tables_[sub.header_].assign(rows.begin(), own);
        tables_[fmt::format("{} kind = \"{}\"", sub.header_, kind)].assign(own, rows.end());
      }
    } else {
      T value{};
      if constexpr (std::is_same_v<T, AxisConfig>) value.wire.drive_unit = any_drive_unit;
      visit(sub, value);
    }
  }
  template <class T, class Visit>
  void optional_list(std::string_view key, std::vector<T>& values, Visit visit) {
    list(key, values, visit);
  }
  template <class Make>
  void alternative(Make) {}
  void takes_effect(Effect) {}

 private:
  void add(std::string_view key, const std::string& range, const std::string& otherwise, const About& about) {
    EXPECT_FALSE(about.meaning.empty()) << header_ << ' ' << key;
    const bool is_of_the_kind = about.otherwise == "of the kind";
    tables_[header_].push_back({std::string(key), is_of_the_kind ? std::string(about.otherwise) : range,
                                about.otherwise.empty() ? otherwise : std::string(about.otherwise),
                                std::string(about.meaning)});
  }
  std::string join(std::string_view key) const {
    return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
  }

  Tables& tables_;
  std::string name_, header_;
};

Tables all_tables() {
  Tables tables;
  Describer describer(tables, {}, false);
  Config config;
  visit(describer, config);
  return tables;
}

/// Parses "[axis.control] from kp to ki_per_s" in a line of the document.
struct Block {
  explicit Block(const std::string& line)
      : header(line.substr(begin.size(), line.rfind(end) - begin.size())) {
    const auto from = header.find(" from "), to = header.find(" to ");
    if (from == std::string::npos || to == std::string::npos) return;
    first = header.substr(from + 6, to - from - 6);
    last = header.substr(to + 4);
    header.resize(from);
  }
  static constexpr std::string_view begin = "<!-- keys: ", end = " -->";
  std::string header, first, last;
};

/// Removes the rows of the block from the tables.
std::string text_of(const Block& block, Tables& tables) {
  std::string text = "| key | unit | range | default | meaning |\n|---|---|---|---|---|\n";
  std::vector<Row>& rows = tables[block.header];
  const auto at = [&](const std::string& key, auto otherwise) {
    return key.empty() ? otherwise : std::ranges::find(rows, key, &Row::key);
  };
  const auto begin = at(block.first, rows.begin());
  auto end = at(block.last, rows.end());
  EXPECT_NE(begin, rows.end()) << block.header << " has no key, or none is left, from " << block.first;
  if (!block.last.empty() && end != rows.end()) ++end;
  for (auto row = begin; row != end; ++row)
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", row->key, unit_of(row->key), row->range,
                        row->otherwise, row->meaning);
  rows.erase(begin, end);
  return text;
}

/// Returns the document with the tables of the program.
std::string with_tables(const std::string& document, Tables& tables) {
  std::istringstream lines(document);
  std::string text, line;
  bool within = false;
  while (std::getline(lines, line)) {
    if (within && line != "<!-- end -->") continue;
    within = line.starts_with(Block::begin);
    text += line + '\n';
    if (within) text += text_of(Block(line), tables);
  }
  return text;
}

/// Removes the rows that another table also contains: the documents show them only there.
void remove_repeated(Tables& tables, const std::string& header, const std::string& other) {
  const std::vector<Row>& shown = tables.at(other);
  std::erase_if(tables.at(header),
                [&](const Row& row) { return std::ranges::find(shown, row) != shown.end(); });
}

TEST(KeyTables, MatchTheProgram) {
  Tables tables = all_tables();
  remove_repeated(tables, "[[axis.sensor_setup]]", "[[axis.amplifier_setup]]");
  remove_repeated(tables, "[axis.frames.status]", "[axis.frames.command]");
  remove_repeated(tables, "[axis.frames.sample]", "[axis.frames.command]");
  for (const char* channel : {"[axis.analogue.position_input]", "[axis.analogue.output_input]"})
    remove_repeated(tables, channel, "[axis.analogue.drive_output]");
  for (const char* line : {"[axis.analogue.interlock_line]", "[axis.analogue.charge_pump_line]"})
    remove_repeated(tables, line, "[axis.analogue.enable_line]");
  remove_repeated(tables, "[[axis.twin.coupling]]", "[[axis.control.coupling]]");
  remove_repeated(tables, R"([[axis.control.setpoint]] kind = "sine")",
                  R"([[axis.control.setpoint]] kind = "triangle")");
  for (const auto& page : std::filesystem::directory_iterator(HYSTCAN_SOURCE_DIR "/docs/configuration")) {
    std::ifstream in(page.path());
    const std::string document{std::istreambuf_iterator<char>(in), {}};
    const std::string expected = with_tables(document, tables);
    if (std::getenv("HYSTCAN_WRITE_KEY_TABLES") != nullptr) std::ofstream(page.path()) << expected;
    EXPECT_EQ(document, expected) << page.path() << ": HYSTCAN_WRITE_KEY_TABLES=1 writes them";
  }
  for (const auto& [header, rows] : tables)
    for (const Row& row : rows)
      ADD_FAILURE() << "the documents have no table with " << row.key << " of " << header;
}

}  // namespace
}  // namespace hystcan::config::key_tables_test
