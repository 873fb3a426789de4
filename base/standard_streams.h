// The standard streams of the program. What a command prints on standard output arrives completely, or the
// command fails.
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

/// Call it first in `main`. A standard stream that is closed gets an open descriptor, so that no file of a
/// command gets its number: what is written to standard output then fails, as on a closed one. A pipe without
/// a reader, or a file that has reached the limit of its size, is an error of the write and does not end the
/// process (SIGPIPE, SIGXFSZ).
void prepare_standard_streams();

/// Without the control characters with which a name from a file or from the bus could command a terminal: as
/// \x1b, but for the line feed and the tab.
std::string printable(std::string_view text);

/// A path in a command that is printed to be typed: with blanks or characters of the shell in quotes.
std::string shell_word(const std::filesystem::path& path);

/// Writes to standard output; to a terminal as printable(). Throws std::system_error if the write fails, for
/// example on a full disk.
void print(std::string_view text);
template <class First, class... Rest>
void print(fmt::format_string<First, Rest...> format, First&& first, Rest&&... rest) {
  print(fmt::format(format, std::forward<First>(first), std::forward<Rest>(rest)...));
}
/// Writes control sequences of a screen to standard output as they are.
void print_sequence(std::string_view text);
/// Throws also if an earlier write failed unchecked.
void flush_output();
/// "standard output: cannot be written: No space left on device".
std::string lost_output_text(std::string_view reason);
/// Writes the results of a live run, which must end: waits at most 5 s for the reader. Returns why they
/// are not printed, if they are not.
std::optional<std::string> print_patiently(std::string_view text);

/// True if a write to standard output has failed. What is still buffered is then discarded.
bool is_lost_output();

/// Runs a command that prints for a reader: a stream of frames, a text. A reader that leaves, as in
/// `hystcan monitor | head -1`, ends the command with `done`.
int print_for_reader(const std::function<int()>& command);

/// Writes control sequences to standard error as they are.
void note_sequence(std::string_view text) noexcept;
/// Writes a remark to standard error, printable(). It need not be read: it is no failure if it cannot be
/// written.
template <class... Values>
void note(fmt::format_string<Values...> format, Values&&... values) {
  note_sequence(printable(fmt::format(format, std::forward<Values>(values)...)));
}

enum class Written : std::uint8_t { all, timed_out, failed };

/// Writes the text to the descriptor and waits at most `timeout` for its reader. Removes what was written
/// from the text. It does not use the buffers of stdio.
Written write_within(int descriptor, std::string_view& text, std::chrono::milliseconds timeout);

}  // namespace hystcan
