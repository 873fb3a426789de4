// Converts the values of an enum to words and back. The words are used in the configuration, in files and in
// reports.
//
// An enum with words has a function words() beside its definition. The function lists the words in the order
// of the enum's values:
//
//   enum class Colour { red, dark_red };
//   constexpr auto words(Colour) { return std::to_array<std::string_view>({"red", "dark-red"}); }
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>

namespace hystcan {

template <class Enum>
concept HasWords = std::is_enum_v<Enum> && requires(Enum value) {
  words(value);
};

template <HasWords Enum>
constexpr std::string_view word_of(Enum value) {
  return words(value)[static_cast<std::size_t>(value)];
}

/// Returns all values of the enum, in the order of their definition.
template <HasWords Enum>
constexpr auto every() {
  std::array<Enum, std::tuple_size_v<std::remove_cvref_t<decltype(words(Enum{}))>>> values{};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<Enum>(i);
  return values;
}

/// Returns the enum value that has this word; returns `nullopt` if the word is unknown.
template <HasWords Enum>
std::optional<Enum> parse_word(std::string_view word) {
  for (const Enum value : every<Enum>())
    if (word_of(value) == word) return value;
  return std::nullopt;
}

}  // namespace hystcan
