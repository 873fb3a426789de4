// Draws plots by gnuplot, if it is installed, from scripts that remain beside the plots.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace hystcan::app {

/// Writes the script to directory/name and runs gnuplot on it there. Returns an empty text on success, else
/// the reason of the failure. The script remains for a later attempt; no plot of its name remains (.svg, .png, .pdf).
/// Throws RunError if the script cannot be written.
std::string draw_with_gnuplot(const std::filesystem::path& directory, const std::string& name,
                              std::string_view script);

/// The text as a gnuplot string constant, in quotes; control characters become spaces.
std::string gnuplot_text(std::string_view text);

}  // namespace hystcan::app
