// Errors that end a command, its exit status, and what a user reads of an exception.
#pragma once

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

namespace hystcan {

/// The input of the user cannot be used. what() is `FILE:LINE:COLUMN: what, expected what`, always in one
/// line.
class Error : public std::runtime_error {
 public:
  explicit Error(std::string what) : std::runtime_error(in_one_line(std::move(what))) {}

 private:
  static std::string in_one_line(std::string text) {
    std::ranges::replace_if(
        text, [](unsigned char c) { return c < 0x20; }, ' ');
    return text;
  }
};

/// Users rely on these values: 0 done, 1 failed while running, 2 bad usage, config, model or data.
enum ExitStatus : int { done = 0, failed = 1, bad_input = 2 };

/// The command failed while running; what() is the reason, in one line.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What the project's own exceptions say. For those of a library: a plain sentence instead of its words.
std::string error_text(const std::exception& error);

}  // namespace hystcan
