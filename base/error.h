// Errors that end a command, the exit status of a command, and the text of an exception for the user.
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

/// Place of an error: a file, with line and column (counted from 1) if they are known; or an option, a key,
/// or a step of the work.
struct Place {
  Place() = default;
  template <std::convertible_to<std::filesystem::path> Name>
  Place(const Name& named, std::size_t at_line = 0, std::size_t at_column = 0)
      : name(std::filesystem::path(named).string()), line(at_line), column(at_column) {}

  std::string name{};
  std::size_t line = 0, column = 0;
};

/// The correct value, and what the user can do.
struct Advice {
  std::string expected{}, remedy{};
};
template <class... Values>
Advice expect(fmt::format_string<Values...> format, Values&&... values) {
  return {.expected = fmt::format(format, std::forward<Values>(values)...)};
}

/// Returns the message of the project's own exceptions. For exceptions of a library, returns a plain sentence
/// instead of its message.
std::string error_text(const std::exception& error);
inline std::string error_text(std::string_view text) { return std::string(text); }

/// what() is `FILE:LINE:COLUMN: what, expected EXPECTED; REMEDY` without empty parts, and with a space for
/// each control character.
class PlacedError : public std::runtime_error {
 public:
  explicit PlacedError(std::string what, Advice advice = {}, Place place = {});
  template <class What>  // a text, or an error that was thrown without a place
  PlacedError(Place place, const What& what, Advice advice = {})
      : PlacedError(error_text(what), std::move(advice), std::move(place)) {}

  const Place& place() const { return place_; }
  const Advice& advice() const { return advice_; }
  /// Returns what() without the remedy.
  std::string finding() const;

  /// If the place is in the folder `from`, renames it to the same file in `to`.
  void rename_folder(const std::string& from, const std::string& to);
  void add_sentence(const std::string& sentence);

 private:
  void form();

  Place place_;
  std::string what_;
  Advice advice_;
};

/// Thrown if the user's input cannot be used.
struct Error : PlacedError {
  using PlacedError::PlacedError;
};

/// Thrown if the command fails while it runs.
struct RunError : PlacedError {
  using PlacedError::PlacedError;
};

/// Runs `body`, which does not handle files: its std::invalid_argument becomes an Error at `place`.
template <class Body>
auto at_place(const Place& place, const Body& body) {
  try {
    return body();
  } catch (const std::invalid_argument& error) {
    throw Error(place, error);
  }
}

/// Users depend on these values. 0: done; 1: failed while running; 2: invalid usage, configuration, model or
/// data.
enum ExitStatus : int { done = 0, failed = 1, bad_input = 2 };

}  // namespace hystcan
