#include "runs/cycle_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <memory>
#include <utility>

#include "base/error.h"
#include "base/text.h"

namespace hystcan::runs {
namespace {

using Kind = controller::CycleColumn::Kind;

/// Returns `file` if it is a regular file; otherwise throws Error. A pipe is refused because it can't be read
/// twice.
std::filesystem::path regular(std::filesystem::path file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored))
    throw Error(file, "is not a file",
                expect("a run's folder or a CSV of control cycles (from hystcan controller --csv)"));
  return file;
}

constexpr const char* needed_columns[] = {"cycle", "time_s", "axis", "state", "position_um"};

/// Returns the bit mask for names joined by "+", for example "slew+model". The name words[i] sets bit i.
/// Returns nullopt if a name is unknown.
std::optional<double> bits_of(std::string_view text, const std::vector<std::string>& words) {
  unsigned bits = 0;
  while (!text.empty()) {
    const std::string_view name = text.substr(0, text.find('+'));
    const auto found = std::ranges::find(words, name);
    if (found == words.end()) return std::nullopt;
    bits |= 1U << (found - words.begin());
    text.remove_prefix(std::min(text.size(), name.size() + 1));
  }
  return bits;
}

}  // namespace

bool has_cycles(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return false;
  std::ifstream stream(file, std::ios::binary);
  const auto buffer = std::make_unique_for_overwrite<char[]>(config::longest_csv_line + 1);
  std::vector<std::string_view> fields;
  while (stream.getline(buffer.get(), config::longest_csv_line + 1)) {
    std::string_view line = without_byte_order_mark(buffer.get());
    while (line.ends_with('\r')) line.remove_suffix(1);
    if (config::trimmed(line).empty() || config::trimmed(line).starts_with('#')) continue;
    config::split_fields(line, ',', fields);
    return std::ranges::all_of(needed_columns,
                               [&](const char* needed) { return std::ranges::count(fields, needed) > 0; });
  }
  return false;
}

CycleReader::CycleReader(std::filesystem::path file) : lines_(regular(std::move(file))) {
  if (!lines_.next())
    lines_.fail("no header row, expected a CSV of control cycles (from hystcan controller --csv)");
  lines_.end_comments();
  config::split_fields(lines_.text(), ',', fields_);
  header_.assign(fields_.begin(), fields_.end());
  for (const char* needed : needed_columns)
    if (!field_of(needed))
      lines_.fail(fmt::format(
          "no column {}, expected a run's folder or a CSV of control cycles (from hystcan controller --csv)",
          needed));
  axis_field_ = *field_of("axis");
}

std::optional<std::size_t> CycleReader::field_of(std::string_view column) const {
  const auto found = std::ranges::find(header_, column);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

bool CycleReader::add(std::string_view column) {
  const controller::CycleColumn* known = controller::find_cycle_column(column);
  if (known == nullptr || known->kind == Kind::axis) {
    std::vector<std::string_view> names;
    for (const auto& each : controller::cycle_columns())
      if (each.kind != Kind::axis) names.push_back(each.name);
    throw Error(fmt::format("no signal {}", config::shortened(column)),
                expect("one of {}", fmt::join(names, ", ")));
  }
  const auto field = field_of(column);
  if (field) wanted_.push_back({known, *field, controller::words_of(*known)});
  return field.has_value();
}

bool CycleReader::next(std::vector<double>& row, std::string_view& axis) {
  if (!lines_.next()) return false;
  config::split_fields(lines_.text(), ',', fields_);
  config::require_width(lines_, fields_.size(), header_.size(), ',');
  axis = fields_[axis_field_];
  row.resize(wanted_.size());
  std::ranges::transform(wanted_, row.begin(), [this](const Wanted& wanted) { return value(wanted); });
  return true;
}

double CycleReader::value(const Wanted& wanted) const {
  const std::string_view text = fields_[wanted.field];
  const char* expected = "a number";
  std::optional<double> value;
  switch (wanted.column->kind) {
    case Kind::limits:
      value = bits_of(text, wanted.words);
      expected = "names of limits";
      break;
    case Kind::state:
    case Kind::cause:
      if (const auto found = std::ranges::find(wanted.words, text); found != wanted.words.end())
        value = static_cast<double>(found - wanted.words.begin());
      expected = wanted.column->kind == Kind::state ? "the name of an axis state in this version of hystcan"
                                                    : "the name of a fault in this version of hystcan";
      break;
    case Kind::whole:
    case Kind::number:
    case Kind::axis:
      value = text.empty() ? std::numeric_limits<double>::quiet_NaN() : parsed_number<double>(text);
      break;
  }
  if (!value)
    lines_.fail(text, fmt::format("{} is \"{}\", expected {}", wanted.column->name, config::shortened(text),
                                  expected));
  return *value;
}

}  // namespace hystcan::runs
