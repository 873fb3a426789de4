// The standard streams of the program. A command either writes its complete output or fails.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace hystcan {

/// Prepares the standard streams; must be the first call in `main`. Opens /dev/null for each standard stream
/// that is closed, so that no other file gets the descriptor of the stream. A write to a closed standard
/// output still fails. Ignores SIGPIPE and SIGXFSZ: if a pipe has no reader or a file is at its size limit,
/// the write fails, but the process does not end.
void prepare_standard_streams();

/// Returns the text with each control character replaced by a code like \x1b. Line feed and tab stay. Names
/// from a file or from the bus could otherwise send commands to the terminal.
std::string printable(std::string_view text);

/// Returns the path as one word of a shell command. Quotes the path if it contains blanks or special
/// characters of the shell.
std::string shell_word(const std::filesystem::path& path);

/// Writes the text to standard output. If standard output is a terminal, applies printable() first. Throws
/// std::system_error if the write fails, for example on a full disk.
void print(std::string_view text);
template <class First, class... Rest>
void print(fmt::format_string<First, Rest...> format, First&& first, Rest&&... rest) {
  print(fmt::format(format, std::forward<First>(first), std::forward<Rest>(rest)...));
}
/// Writes the text to standard output without printable(), for control sequences of a terminal.
void print_sequence(std::string_view text);
/// Flushes standard output. Throws std::system_error if this write or an earlier unchecked write has failed.
void flush_output();
/// Returns the error message for standard output, for example "standard output: cannot be written: No space
/// left on device".
std::string lost_output_text(std::string_view reason);
/// Writes the results of a live run to standard output. Waits at most 5 s for the reader of a pipe, because
/// the run must end. If the write fails, returns the reason.
std::optional<std::string> print_patiently(std::string_view text);

/// Returns true if a write to standard output has failed. Then the text that is still in the buffer is
/// discarded.
bool is_lost_output();

/// Runs a command that prints a long output. If the reader closes the pipe early, as in `hystcan monitor |
/// head -1`, returns `done` instead of an error.
int print_for_reader(const std::function<int()>& command);

/// Writes the text to standard error without printable(), for control sequences of a terminal.
void note_sequence(std::string_view text) noexcept;
/// Formats a remark, applies printable() and writes the remark to standard error. Ignores a failed write,
/// because the command does not depend on the remark.
template <class... Values>
void note(fmt::format_string<Values...> format, Values&&... values) {
  note_sequence(printable(fmt::format(format, std::forward<Values>(values)...)));
}

enum class Written : std::uint8_t { all, timed_out, failed };

/// Writes the text to the descriptor. Waits at most `timeout` in total until the reader accepts the text. On
/// return, `text` is the part that was not written. Bypasses the buffers of stdio.
Written write_within(int descriptor, std::string_view& text, std::chrono::milliseconds timeout);

}  // namespace hystcan
