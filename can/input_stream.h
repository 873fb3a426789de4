// A file that a command reads once from its beginning. It may be a pipe (/dev/stdin, a FIFO).
#pragma once

#include <chrono>
#include <filesystem>
#include <istream>
#include <memory>

namespace hystcan::can {

/// How long a FIFO may wait for a process that opens it for writing.
inline constexpr std::chrono::seconds patience_with_a_fifo{3};

/// Throws FileError (can/regular_file.h) if the file cannot be opened, is a directory, or is a FIFO that nobody
/// opens for writing. A signal that interrupts a wait for data makes the stream bad().
std::unique_ptr<std::istream> open_input(const std::filesystem::path& file,
                                         std::chrono::milliseconds patience = patience_with_a_fifo);

}  // namespace hystcan::can
