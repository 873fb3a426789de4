#include "config/files/record_head.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "config/files/csv.h"
#include "config/files/number_signs.h"
#include "config/files/record_words.h"

namespace hystcan::config {
namespace {

using Fields = std::vector<std::string_view>;

/// Returns the text without blanks, separators, quotes and brackets at both ends.
std::string_view without_marks(std::string_view text) {
  constexpr std::string_view marks = "# \t:=;,\"()[]|";
  const auto begin = text.find_first_not_of(marks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(marks) - begin + 1);
}

/// Returns the unit in a field of a line of units, for example "V" for "(V)"; nullopt if the field is not a
/// unit.
std::optional<std::string> only_unit(std::string_view field) {
  const CsvColumn column = csv_column(field);
  if (column.name.empty() && !column.unit.empty()) return column.unit;
  const UnitWord* known = find_unit(column.title);
  if (known == nullptr) return std::nullopt;
  return std::string(known->symbol);
}

// The functions below are the ways to split a line of column names into fields.

Fields split_by(std::string_view line, char separator) {
  Fields fields;
  split_fields(line, separator, fields);
  return fields;
}

/// Splits a line at two or more blanks, or at a tab. A single blank is part of a name.
Fields split_at_gaps(std::string_view line) {
  Fields fields;
  for (line = trimmed(line); !line.empty();) {
    const std::size_t end = std::min({line.size(), line.find("  "), line.find('\t')});
    fields.push_back(trimmed(line.substr(0, end)));
    line = trimmed(line.substr(end));
  }
  return fields;
}

/// Splits a line at blanks, but not before a unit in parentheses or brackets: "drive [V]" is one field.
Fields split_before_brackets(std::string_view line) {
  Fields fields;
  for (const std::string_view field : split_by(line, ' ')) {
    const bool is_unit = !field.empty() && (field.front() == '(' || field.front() == '[');
    if (is_unit && !fields.empty())
      fields.back() = {fields.back().data(),
                       static_cast<std::size_t>(field.data() + field.size() - fields.back().data())};
    else
      fields.push_back(field);
  }
  return fields;
}

class HeadReader {
 public:
  HeadReader(const std::vector<TextLine>& lines, const RowShape& shape) : lines_(lines), shape_(shape) {}

  RecordHead read(const std::vector<TextLine>& beside) {
    for (const TextLine& line : lines_) {
      const std::string_view text = trimmed(line.text);
      if (text.starts_with('#') && head_.comments.size() < most_comments && text.size() <= longest_comment)
        head_.comments.emplace_back(text);
    }
    read_names();
    read_settings(lines_);
    if (!beside.empty()) read_settings(beside);
    return std::move(head_);
  }

 private:
  bool is_used(std::size_t column) const {
    return shape_.rows == 0 || (column < shape_.width() && shape_.numbers[column]);
  }

  bool fits(const Fields& fields) const {
    if (fields.size() + 1 < shape_.width() || fields.size() > shape_.width() + 1) return false;
    bool has_text = false, has_setting = false, has_number = false;
    std::set<std::string_view> texts;
    std::size_t used = 0;
    for (std::size_t i = 0; i < shape_.width(); ++i) {
      if (!is_used(i)) continue;
      ++used;
      const bool may_have_no_name = i == 0;  // the first column may be a row number without a name
      if (i >= fields.size() || (fields[i].empty() && !may_have_no_name)) return false;
      texts.insert(fields[i]);
      has_text = has_text || (!fields[i].empty() && !is_value(fields[i]));
      has_setting = has_setting || find_setting(lower_case(without_marks(fields[i])));
      has_number = has_number || is_value(fields[i]);
      const bool is_channel = fields[i].size() <= 2 && std::ranges::all_of(fields[i], is_digit);
      if (is_value(fields[i]) && !is_channel) return false;
    }
    if (has_setting && has_number) return false;
    if (used > 1 && texts.size() == 1) return false;
    return has_text;
  }

  /// Returns the column names in a line above the rows; empty if the fields of the line do not match the
  /// columns.
  Fields names_in(const TextLine& line) const {
    std::string_view text = trimmed(line.text);
    if (shape_.rows > 0 && has_shape(split_by(text, shape_.separator), shape_)) return {};
    const bool is_marked = !text.empty() && text.front() != shape_.separator &&
                           std::string_view("#%;!").find(text.front()) != std::string_view::npos;
    const bool is_comment = is_marked || text.starts_with("//");
    if (is_comment) {
      if (text.find('=') != std::string_view::npos) return {};
      text = trimmed(text.substr(std::min(text.find_first_not_of("#%/;!"), text.size())));
    }
    std::vector<Fields> ways{split_by(text, shape_.separator)};
    if (shape_.separator == ' ') {
      ways.clear();
      for (const char separator : {'\t', ';', ','})
        if (text.find(separator) != std::string_view::npos) ways.push_back(split_by(text, separator));
      ways.push_back(split_at_gaps(text));
      ways.push_back(split_before_brackets(text));
      ways.push_back(split_by(text, ' '));
    } else if (is_comment) {
      ways.push_back(split_before_brackets(text));
    }
    for (Fields& fields : ways)
      if (fits(fields)) return std::move(fields);
    return {};
  }

  /// Returns the units in a line; nullopt if this is not a line of units. In a line of units, each field
  /// above a column of numbers is a known unit. If the first field is a unit of time or a name such as
  /// "sample", this is probably a line of units, so that half of the fields may have unknown units.
  std::optional<std::vector<std::string>> units_in(const TextLine& line) const {
    const std::string_view text =
        trimmed(line.text.substr(std::min(line.text.find_first_not_of("#% \t"), line.text.size())));
    Fields fields = split_by(text, shape_.separator);
    if (fields.size() + 1 < shape_.width() || fields.size() > shape_.width() + 1) return std::nullopt;
    std::size_t known = 0, used = 0;
    bool begins_with_time = false;
    std::vector<std::string> units(shape_.width());
    for (std::size_t i = 0; i < std::min(fields.size(), shape_.width()); ++i) {
      if (is_used(i)) ++used;
      const std::optional<std::string> unit = only_unit(fields[i]);
      if (unit && is_used(i)) ++known;
      const UnitWord* word = unit ? find_unit(*unit) : nullptr;
      const bool is_time = word != nullptr && word->meaning == ColumnMeaning::time;
      const bool is_clock = is_clock_form(fields[i]);
      if (is_used(i) && used == 1)
        begins_with_time = is_time || is_clock || counts_samples(lower_case(without_quotes(fields[i])));
      units[i] = unit ? *unit : without_quotes(fields[i]);
      if (is_value(fields[i]) || is_clock) units[i].clear();
    }
    const bool has_all = known == used || (begins_with_time && 2 * known >= used);
    if (known == 0 || !has_all) return std::nullopt;
    return units;
  }

  void read_names() {
    constexpr std::size_t most_lines = 50;
    std::optional<std::vector<std::string>> units;
    Fields names;
    std::size_t line = 0, above = 0;
    for (std::size_t n = 0; n < std::min(most_lines, lines_.size()); ++n) {
      const TextLine& each = lines_[lines_.size() - 1 - n];
      if (each.is_blank()) continue;
      const Fields found = names_in(each);
      std::optional<std::vector<std::string>> own = units_in(each);
      if (own && !units && (!found.empty() || names.empty()) && is_below_names(lines_.size() - 1 - n)) {
        units = std::move(own);
        continue;
      }
      if (found.empty()) continue;
      const bool is_known = std::ranges::any_of(found, is_known_name);
      if (names.empty() || is_known) {
        names = found;
        if (own && !units) units = std::move(own);  // a line of units such as ms,V,um also serves as names
        line = each.number;
        above = lines_.size() - 1 - n;
      }
      if (is_known) break;
    }
    if (!units && line > 0) units = units_above(above);
    head_.has_names = !names.empty();
    if (head_.has_names) head_.line = line;
    for (std::size_t i = 0; i < shape_.width(); ++i) {
      const bool is_named = i < names.size();
      head_.columns.push_back(is_named ? csv_column(names[i]) : CsvColumn{});
      CsvColumn& column = head_.columns.back();
      if (!head_.has_names) column.title = column.name = std::to_string(i + 1);
      if (!units || (*units)[i].empty()) continue;
      if (counts_samples(lower_case((*units)[i])))
        column.name = lower_case((*units)[i]);
      else if (column.unit.empty() || find_unit(column.unit) == nullptr)
        column.unit = (*units)[i];
    }
  }

  static bool is_known_name(std::string_view field) {
    const CsvColumn column = csv_column(field);
    const std::string name = lower_case(column.name);
    return find_unit(column.unit) != nullptr || name_likeness(name, ColumnMeaning::time) > 0 ||
           name_likeness(name, ColumnMeaning::input) > 0 || name_likeness(name, ColumnMeaning::output) > 0;
  }

  /// Returns the units in the line above the names; nullopt if the unit of a number column is unknown.
  std::optional<std::vector<std::string>> units_above(std::size_t index) const {
    while (index > 0 && lines_[index - 1].is_blank()) --index;
    if (index == 0) return std::nullopt;
    auto units = units_in(lines_[index - 1]);
    for (std::size_t i = 0; units && i < shape_.width(); ++i)
      if (is_used(i) && find_unit((*units)[i]) == nullptr) units.reset();
    return units;
  }

  /// Returns true if a line of column names is above the line with this index. A line of units does not count
  /// as a line of names.
  bool is_below_names(std::size_t index) const {
    for (std::size_t n = 0; n < 3 && index > 0;) {
      const TextLine& above = lines_[--index];
      if (above.is_blank()) continue;
      if (const Fields names = names_in(above); !names.empty()) return !units_in(above);
      ++n;
    }
    return false;
  }

  /// Reads the sampling rate and the units from the instrument's settings. A setting has a known name, such
  /// as "Sample Interval". Its value is in the same field or in the next fields. A rate may also be in the
  /// next line, in the field below the name.
  void read_settings(const std::vector<TextLine>& lines) {
    std::vector<StatedRate> rates;
    for (std::size_t n = 0; n < lines.size(); ++n) {
      const Fields fields = split_by(lines[n].text, shape_.separator == ' ' ? '\t' : shape_.separator);
      for (std::size_t i = 0; i < fields.size(); ++i) {
        const std::string lower = lower_case(without_marks(fields[i]));
        const std::optional<FoundSetting> found = find_setting(lower);
        if (!found) continue;
        const std::string rest(without_marks(std::string_view(lower).substr(found->length)));
        if (found->setting == RecordSetting::rate_Hz || found->setting == RecordSetting::interval_s) {
          std::string value = rest;
          for (std::size_t j = i + 1; j < std::min(i + 3, fields.size()) && fields[j] != fields[i]; ++j)
            if (j == i + 1 || fields[j] != fields[j - 1])  // the same rate may be repeated for each channel
              value += " " + lower_case(without_marks(fields[j]));
          if (n + 1 < lines.size() && value.find_first_of("0123456789") == std::string::npos)
            if (const Fields below = split_by(lines[n + 1].text, shape_.separator); i < below.size())
              value += " " + lower_case(without_marks(below[i]));
          if (const auto rate = rate_of(value, found->setting))
            rates.push_back({*rate, std::string(trimmed(lines[n].text))});
        } else {
          take_units(fields, i, found->setting, without_marks(fields[i]).substr(found->length));
        }
      }
    }
    const auto is_first = [&](const StatedRate& one) { return one.rate_Hz == rates.front().rate_Hz; };
    if (!rates.empty() && std::ranges::all_of(rates, is_first)) head_.rate = rates.front();
  }

  /// Returns the sampling rate in Hz. `text`, in lower case, is a rate ("5 khz", "[hz] 5000") or an interval
  /// ("0.2 ms", "ch1:0.01 ch2:0.01" in s); see `setting`. Returns nullopt for a missing or ambiguous rate.
  static std::optional<double> rate_of(std::string_view text, RecordSetting setting) {
    std::size_t begin = 0;
    const auto is_start = [&](std::size_t at) {
      const bool is_in_word =
          at > 0 && (std::isalnum(static_cast<unsigned char>(text[at - 1])) != 0 || text[at - 1] == '-');
      return text[at] >= '0' && text[at] <= '9' && !is_in_word;
    };
    while (begin < text.size() && !is_start(begin)) ++begin;
    std::size_t end = std::min(text.find_first_not_of("0123456789.,", begin), text.size());
    if (end + 1 < text.size() && text[end] == 'e' && text.find_first_of("0123456789", end) <= end + 2)
      end = std::min(text.find_first_not_of("0123456789", end + 2), text.size());
    const std::string_view number = without_marks(text.substr(begin, end - begin));
    std::string_view before = without_marks(text.substr(0, begin)), behind = without_marks(text.substr(end));
    if (before.find(':') != std::string_view::npos ||
        (!before.empty() && text[begin - 1] == ':')) {  // a rate for each channel: ch1:0.01 ch2:0.01
      const std::size_t again = behind.find(':');
      if (again != std::string_view::npos && without_marks(behind.substr(again)) != number)
        return std::nullopt;
      before = behind = {};
    }
    const auto value = csv_number(number, true);
    const std::size_t point = number.find_first_of(".,");
    if (!value || !(*value > 0.0)) return std::nullopt;
    if (point != std::string_view::npos && number.size() - point == 4 && number.front() != '0')
      return std::nullopt;  // the number is ambiguous: 5.000 is five or five thousand
    const std::string unit = std::string(before) + std::string(behind);
    if (setting == RecordSetting::interval_s) {
      const UnitWord* known = unit.empty() ? find_unit("s") : find_unit(unit);
      if (known == nullptr || known->base != "s") return std::nullopt;
      return 1.0 / (*value * known->factor);
    }
    constexpr std::array<std::string_view, 6> per_second{"", "hz", "1/s", "s/s", "sa/s", "samples/s"};
    constexpr std::array<std::string_view, 3> per_millisecond{"khz", "ks/s", "ksa/s"};
    if (std::ranges::find(per_second, unit) != per_second.end()) return *value;
    if (std::ranges::find(per_millisecond, unit) != per_millisecond.end()) return *value * 1e3;
    return std::nullopt;
  }

  using ValueOfField = std::pair<std::size_t, std::string_view>;

  /// Returns the texts that belong to the setting in field `at`: the rest of this field, and the following
  /// fields up to the next setting.
  static std::vector<ValueOfField> values_of(const Fields& fields, std::size_t at, std::string_view rest) {
    std::vector<ValueOfField> values;
    if (!without_marks(rest).empty()) values.emplace_back(at, without_marks(rest));
    for (std::size_t j = at + 1; j < fields.size() && !find_setting(lower_case(without_marks(fields[j])));
         ++j)
      if (!fields[j].empty() && !is_value(fields[j])) values.emplace_back(j, fields[j]);
    return values;
  }

  /// A unit in an instrument setting, and the column to which the unit belongs.
  struct UnitSetting {
    bool is_of_time = false, is_alone = false;
    std::string_view channel{};              ///< name before a unit: CH1 in CH1:V; empty: no name
    std::size_t target = std::string::npos;  ///< index of the column that gets the unit; npos: unknown
    std::size_t field = 0;                   ///< index of the field that contains the unit
  };

  /// Assigns the units of a setting to columns. In `CH1:V CH2:mV`, each unit belongs to the column with the
  /// name before the colon. Units without names belong to the columns in order if there are as many units as
  /// columns (targets_of()). Otherwise the position of a unit in its line is the position of its column. If a
  /// single unit is at the first column of numbers or at none, it belongs to all columns except the time.
  void take_units(const Fields& fields, std::size_t at, RecordSetting setting, std::string_view rest) {
    const std::vector<ValueOfField> values = values_of(fields, at, rest);
    const std::vector<std::size_t> targets = targets_of(values.size());
    UnitSetting by{.is_of_time = setting == RecordSetting::time_unit, .is_alone = values.size() == 1};
    for (std::size_t k = 0; k < values.size(); ++k) {
      by.field = values[k].first;
      if (!targets.empty()) by.target = targets[k];
      for (const std::string_view token : split_by(values[k].second, ' ')) {
        const std::size_t colon = token.find(':');
        const bool names_channel = colon != std::string_view::npos;
        by.channel = names_channel ? token.substr(0, colon) : std::string_view();
        const std::string_view text = names_channel ? token.substr(colon + 1) : token;
        if (find_unit(without_quotes(text)) != nullptr) take_unit(symbol_of(without_quotes(text)), by);
      }
    }
  }

  void take_unit(const std::string& unit, const UnitSetting& by) {
    for (std::size_t i = 0; i < head_.columns.size(); ++i)
      if (is_used(i) && head_.columns[i].unit.empty() && is_meant(i, by)) head_.columns[i].unit = unit;
  }

  bool is_meant(std::size_t column, const UnitSetting& by) const {
    if (by.is_of_time) return is_time(column);
    if (!by.channel.empty()) return head_.columns[column].name == by.channel;
    if (by.target != std::string::npos) return column == by.target;
    if (is_used(by.field) && (!by.is_alone || by.field != first_used())) return column == by.field;
    return !is_time(column);
  }

  /// Returns the indices of the columns to which a list of `units` units belongs: all number columns, or all
  /// except the time. Returns an empty list if the number of units fits neither.
  std::vector<std::size_t> targets_of(std::size_t units) const {
    std::vector<std::size_t> all, channels;
    for (std::size_t i = 0; i < shape_.width(); ++i) {
      if (!is_used(i)) continue;
      all.push_back(i);
      if (!is_time(i)) channels.push_back(i);
    }
    if (units < 2) return {};
    if (units == all.size()) return all;
    if (units == channels.size()) return channels;
    return {};
  }

  bool is_time(std::size_t column) const {
    const std::string name = lower_case(head_.columns[column].name);
    const bool is_channel =
        name_likeness(name, ColumnMeaning::input) > 0 || name_likeness(name, ColumnMeaning::output) > 0;
    return name_likeness(name, ColumnMeaning::time) > 0 || (column == first_used() && !is_channel);
  }

  std::size_t first_used() const {
    return static_cast<std::size_t>(std::ranges::find(shape_.numbers, true) - shape_.numbers.begin());
  }

  const std::vector<TextLine>& lines_;
  const RowShape& shape_;
  RecordHead head_;
};

}  // namespace

RecordHead read_head(const std::vector<TextLine>& lines, const RowShape& shape,
                     const std::vector<TextLine>& beside) {
  return HeadReader(lines, shape).read(beside);
}

}  // namespace hystcan::config
