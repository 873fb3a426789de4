// Draws plots by gnuplot, if it is installed, from scripts that remain beside the plots.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::app {

/// Writes the script to directory/name and runs gnuplot on it there. Returns an empty text when each picture, the
/// script's name with one of these endings ("svg", "png", "pdf"), is there and whole: gnuplot itself succeeds on a full
/// disk. Else the reason of the failure; the script remains for a later attempt, and no picture of its name.
/// Throws RunError if the script cannot be written.
std::string draw_with_gnuplot(const std::filesystem::path& directory, const std::string& name,
                              const std::vector<std::string>& endings, std::string_view script);

/// The text as a gnuplot string constant, in quotes; control characters become spaces.
std::string gnuplot_string(std::string_view text);

/// Text that a picture shows as it is: without this, "_" and "^" would set what follows lower or higher.
std::string gnuplot_text(std::string_view text);

/// A file in the script's folder as a gnuplot string constant: never a command, which '|' and '<' would begin.
std::string gnuplot_file(std::string_view name);

/// The text as the name of a file, or a part of one, in any folder: of A-Z, a-z, 0-9, '.', '-', '+' and '_', which
/// stands for all others, and not hidden.
std::string file_name_of(std::string_view text);

}  // namespace hystcan::app
