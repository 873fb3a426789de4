// The standard streams of the program. Either the output of a command arrives completely, or the command
// fails.
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

/// Must be called first in `main`. Opens a descriptor for each closed standard stream, so that no file of a
/// command gets its number; a write to standard output then fails, as on a closed stream. A pipe without a
/// reader, or a file at its size limit, makes the write fail and does not end the process (SIGPIPE, SIGXFSZ).
void prepare_standard_streams();

/// Returns the text with control characters as \x1b etc., except line feed and tab, because a name from a
/// file or from the bus could otherwise control the terminal.
std::string printable(std::string_view text);

/// Returns a path for use in a printed command: quoted if it contains blanks or characters of the shell.
std::string shell_word(const std::filesystem::path& path);

/// Writes to standard output, and applies printable() if it is a terminal. Throws std::system_error if the
/// write fails, for example on a full disk.
void print(std::string_view text);
template <class First, class... Rest>
void print(fmt::format_string<First, Rest...> format, First&& first, Rest&&... rest) {
  print(fmt::format(format, std::forward<First>(first), std::forward<Rest>(rest)...));
}
/// Writes control sequences for the screen to standard output unchanged.
void print_sequence(std::string_view text);
/// Flushes standard output. Also throws if an earlier unchecked write has failed.
void flush_output();
/// Example: "standard output: cannot be written: No space left on device".
std::string lost_output_text(std::string_view reason);
/// Writes the results of a live run that must end: waits at most 5 s for the reader. If they could not be
/// printed, returns the reason.
std::optional<std::string> print_patiently(std::string_view text);

/// True if a write to standard output has failed. The buffered rest is then discarded.
bool is_lost_output();

/// Runs a command that prints a stream of frames or a text. If the reader closes its end, as in `hystcan
/// monitor | head -1`, the command ends with `done`.
int print_for_reader(const std::function<int()>& command);

/// Writes control sequences to standard error unchanged.
void note_sequence(std::string_view text) noexcept;
/// Writes a remark to standard error, with printable(). Ignores a failed write, because nobody has to read
/// the remark.
template <class... Values>
void note(fmt::format_string<Values...> format, Values&&... values) {
  note_sequence(printable(fmt::format(format, std::forward<Values>(values)...)));
}

enum class Written : std::uint8_t { all, timed_out, failed };

/// Writes the text to the descriptor and waits at most `timeout` for its reader. Removes the written part
/// from the text. Does not use the buffers of stdio.
Written write_within(int descriptor, std::string_view& text, std::chrono::milliseconds timeout);

}  // namespace hystcan
