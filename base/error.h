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

/// The place of an error. `name` is a file, an option, a key, or a step of the work. For a file, `line` and
/// `column` count from 1; 0 means that they are not known.
struct Place {
  Place() = default;
  template <std::convertible_to<std::filesystem::path> Name>
  Place(const Name& named, std::size_t at_line = 0, std::size_t at_column = 0)
      : name(std::filesystem::path(named).string()), line(at_line), column(at_column) {}

  std::string name{};
  std::size_t line = 0, column = 0;
};

/// Two optional parts of an error message: the value that would be correct, and what the user can do.
struct Advice {
  std::string expected{}, remedy{};
};
template <class... Values>
Advice expect(fmt::format_string<Values...> format, Values&&... values) {
  return {.expected = fmt::format(format, std::forward<Values>(values)...)};
}

/// Returns the text of an exception for the user. For an exception of this project, the text is its message.
/// For an exception of a library, the text is a plain sentence instead of the library's message.
std::string error_text(const std::exception& error);
inline std::string error_text(std::string_view text) { return std::string(text); }

/// An error with its place and advice. what() returns `FILE:LINE:COLUMN: what, expected EXPECTED; REMEDY`.
/// Empty parts are left out, and each control character is replaced by a space.
class PlacedError : public std::runtime_error {
 public:
  explicit PlacedError(std::string what, Advice advice = {}, Place place = {});
  template <class What>  // `what`: a text, or an exception without a place
  PlacedError(Place place, const What& what, Advice advice = {})
      : PlacedError(error_text(what), std::move(advice), std::move(place)) {}

  const Place& place() const { return place_; }
  const Advice& advice() const { return advice_; }
  /// Returns what() without the remedy.
  std::string finding() const;

  /// If the place of the error is a file in the folder `from`, replaces this folder by `to` in the file name.
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

/// Runs `body`. If `body` throws std::invalid_argument, throws an Error with the same text at `place`. `body`
/// must not read or write files, because a std::invalid_argument about a file would then be reported at the
/// wrong place.
template <class Body>
auto at_place(const Place& place, const Body& body) {
  try {
    return body();
  } catch (const std::invalid_argument& error) {
    throw Error(place, error);
  }
}

/// The exit status of the program. Scripts of users depend on these values. 0: the command succeeded. 1: it
/// failed while it ran. 2: its arguments, configuration, model or data are not valid.
enum ExitStatus : int { done = 0, failed = 1, bad_input = 2 };

}  // namespace hystcan
