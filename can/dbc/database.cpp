#include "can/dbc/database.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include "base/input_file.h"
#include "base/text.h"
#include "can/dbc/grammar.h"
#include "can/dbc/limits.h"
#include "can/dbc/reader.h"

namespace hystcan::can {
namespace {

/// Finds line and column of a place in the text. Lines end with LF, CR LF or CR.
class Places {
 public:
  Places(std::string_view text, const std::string& file_name) : text_(text), file_name_(file_name) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      const bool ends = text[i] == '\n' || (text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n'));
      if (ends) line_starts_.push_back(i + 1);
    }
  }

  std::string operator()(const char* where) const {
    const auto at = static_cast<std::size_t>(where - text_.data());
    const auto line = std::upper_bound(line_starts_.begin(), line_starts_.end(), at) - 1;
    return file_name_ + ':' + std::to_string(line - line_starts_.begin() + 1) + ':' +
           std::to_string(at - *line + 1);
  }

 private:
  std::string_view text_;
  const std::string& file_name_;
  std::vector<std::size_t> line_starts_{0};
};

std::vector<std::string> located(std::vector<dbc::ParseWarning> warnings, const Places& place) {
  std::ranges::stable_sort(warnings, std::less<>{}, &dbc::ParseWarning::where);
  std::vector<std::string> lines;
  lines.reserve(warnings.size());
  for (const auto& [where, what] : warnings) lines.push_back(place(where) + ": " + what);
  return lines;
}

template <class Named>
const Named* find_named(const std::vector<Named>& all, std::string_view name) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Named& each) { return each.name == name; });
  if (found != all.end()) return &*found;
  const auto has_short_name = [&](const Named& each) { return each.short_name == name && !name.empty(); };
  const auto first = std::find_if(all.begin(), all.end(), has_short_name);
  const bool only = first != all.end() && std::none_of(std::next(first), all.end(), has_short_name);
  return only ? &*first : nullptr;
}

}  // namespace

bool is_decodable(const Signal& signal) {
  return signal.length >= 1 && signal.length <= 64 && signal.value_type != ValueType::unreadable;
}

std::size_t bytes_needed(const Signal& signal) {
  const std::size_t first =  // in wire order
      signal.byte_order == ByteOrder::little_endian ? signal.start_bit : signal.start_bit ^ 7U;
  return (first + signal.length + 7) / 8;
}

const Signal* Message::find(std::string_view signal) const { return find_named(signals, signal); }

const Message* Database::find(std::string_view message) const { return find_named(messages, message); }

const AttributeValue* attribute(const Database& database, const Attributes& given, std::string_view name) {
  if (const auto own = given.find(name); own != given.end()) return &own->second;
  const auto defined = database.attribute_definitions.find(name);
  if (defined == database.attribute_definitions.end() || !defined->second.default_value) return nullptr;
  return &*defined->second.default_value;
}

Database parse_dbc(std::string_view text, const std::string& file_name) {
  if (is_utf16(text)) throw DbcError(file_name + ":1:1: " + std::string(refusal_of_encoding(text)));
  text = without_byte_order_mark(text);
  try {
    dbc::Document document = dbc::parse_document(text);
    Database database = dbc::read_document(document);
    database.further_warnings = document.warnings.further;
    if (!document.warnings.kept.empty())
      database.warnings = located(std::move(document.warnings.kept), Places(text, file_name));
    return database;
  } catch (const dbc::ParseError& error) {
    throw DbcError(Places(text, file_name)(error.where) + ": found " + error.found + ", expected " +
                   error.expected);
  }
}

Database load_dbc(const std::filesystem::path& file) {
  try {
    return parse_dbc(read_regular_file(file, dbc::largest_file), file.string());
  } catch (const FileError& error) {
    throw DbcError(file.string() + ": cannot be read: " + error.what());
  }
}

}  // namespace hystcan::can
