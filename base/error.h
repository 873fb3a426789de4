// Errors that end a command, its exit status, and what a user reads of an exception.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace hystcan {

/// A file, with a line and a column from 1 if they are known; else an option, a key or a step of the work.
struct Place {
  Place() = default;
  template <std::convertible_to<std::filesystem::path> Name>
  Place(const Name& named, std::size_t at_line = 0, std::size_t at_column = 0)
      : name(std::filesystem::path(named).string()), line(at_line), column(at_column) {}

  std::string name{};
  std::size_t line = 0, column = 0;
};

/// The value that would be right, and what the user can do.
struct Advice {
  std::string expected{}, remedy{};
};
template <class... Values>
Advice expect(fmt::format_string<Values...> format, Values&&... values) {
  return {.expected = fmt::format(format, std::forward<Values>(values)...)};
}

/// What the project's own exceptions say. For those of a library: a plain sentence instead of its words.
std::string error_text(const std::exception& error);
inline std::string error_text(std::string_view text) { return std::string(text); }

/// what() is `FILE:LINE:COLUMN: what, expected EXPECTED; REMEDY` without the parts that are empty, and with a
/// space for each control character.
class PlacedError : public std::runtime_error {
 public:
  explicit PlacedError(std::string what, Advice advice = {}, Place place = {});
  template <class What>  // a text, or an error whose thrower does not know the place
  PlacedError(Place place, const What& what, Advice advice = {})
      : PlacedError(error_text(what), std::move(advice), std::move(place)) {}

  /// If the place is in the folder `from`, it gets the name that it has in `to`.
  void rename_folder(const std::string& from, const std::string& to);
  void add_sentence(const std::string& sentence);

 private:
  void form();

  Place place_;
  std::string what_;
  Advice advice_;
};

/// The input of the user cannot be used.
struct Error : PlacedError {
  using PlacedError::PlacedError;
};

/// The command failed while running.
struct RunError : PlacedError {
  using PlacedError::PlacedError;
};

/// Runs a part of the program that knows no files: its std::invalid_argument becomes an Error at the place.
template <class Body>
auto at_place(const Place& place, const Body& body) {
  try {
    return body();
  } catch (const std::invalid_argument& error) {
    throw Error(place, error);
  }
}

/// Users rely on these values: 0 done, 1 failed while running, 2 bad usage, config, model or data.
enum ExitStatus : int { done = 0, failed = 1, bad_input = 2 };

}  // namespace hystcan
