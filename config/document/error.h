// The error of all input that a user writes.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace hystcan::config {

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

}  // namespace hystcan::config
