// Reads a file that the user names, without the traps of other kinds of file: a pipe or a terminal would wait
// for its other end, and a device never ends.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace hystcan::can {

/// The file cannot be read. what() is the reason without the name of the file: "Is a directory".
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The content of a regular file. Throws FileError if the file cannot be opened, is not a regular file, or has
/// more than `largest` bytes. It never waits for another process.
std::string read_regular_file(const std::filesystem::path& file, std::size_t largest);

}  // namespace hystcan::can
