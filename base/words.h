// The words of an enum: the names of its values in the configuration, the files and the reports.
//
// An enum with words lists them once, next to its definition and in the order of its values:
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

/// Returns every value, in order.
template <HasWords Enum>
constexpr auto every() {
  std::array<Enum, std::tuple_size_v<std::remove_cvref_t<decltype(words(Enum{}))>>> values{};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<Enum>(i);
  return values;
}

/// Returns the value with this word; `nullopt` if there is none.
template <HasWords Enum>
std::optional<Enum> parse_word(std::string_view word) {
  for (const Enum value : every<Enum>())
    if (word_of(value) == word) return value;
  return std::nullopt;
}

}  // namespace hystcan
