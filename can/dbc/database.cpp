#include "can/dbc/database.h"

#include <algorithm>
#include <functional>
#include <iterator>

#include "base/input_file.h"
#include "base/text.h"
#include "can/dbc/reader.h"

namespace hystcan::can {
namespace {

/// Converts positions in the text to line and column. Successive calls must have ascending positions. Lines
/// end with LF, CR LF or CR.
class Places {
 public:
  Places(std::string_view text, const std::string& file_name)
      : file_name_(file_name), at_(text.data()), end_(text.data() + text.size()) {}

  Place operator()(const char* where) {
    for (; at_ != where; ++at_, ++column_) {
      const bool ends = *at_ == '\n' || (*at_ == '\r' && (at_ + 1 == end_ || at_[1] != '\n'));
      if (!ends) continue;
      ++line_;
      column_ = 0;
    }
    return {file_name_, line_, column_};
  }

 private:
  const std::string& file_name_;
  const char* at_;
  const char* end_;
  std::size_t line_ = 1;
  std::size_t column_ = 1;
};

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
  const std::size_t first =  // number of the first bit; in big-endian, bit 0 is the highest bit of byte 0
      signal.byte_order == ByteOrder::little_endian ? signal.start_bit : signal.start_bit ^ 7U;
  return (first + signal.length + 7) / 8;
}

const Signal* Message::find(std::string_view signal) const { return find_named(signals, signal); }

const Message* Database::find(std::string_view message) const { return find_named(messages, message); }

Database parse_dbc(std::string_view text, const std::string& file_name) {
  if (is_utf16(text)) throw Error({file_name, 1, 1}, refusal_of_encoding(text));
  text = without_byte_order_mark(text);
  Places place(text, file_name);
  try {
    dbc::Reader reader(text);
    Database database = reader.read();
    auto& warnings = reader.warnings();
    std::ranges::stable_sort(warnings, std::less<>{}, &dbc::Reader::Warning::first);
    database.warnings.reserve(warnings.size());
    for (const auto& [where, what] : warnings)
      database.warnings.emplace_back(Error(place(where), what).what());
    return database;
  } catch (const dbc::ParseError& error) {
    throw Error(place(error.where), "found " + error.found, {.expected = error.expected});
  }
}

Database load_dbc(const std::filesystem::path& file) {
  return parse_dbc(read_regular_file(file, dbc::largest_file), file.string());
}

}  // namespace hystcan::can
