// Pictures are drawn by gnuplot, where it is installed, from scripts that stay beside them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace hystcan::app {

/// Writes the script to directory/name and runs gnuplot on it there. Empty where it drew, else why not; the
/// script stays for a later try.
std::string draw_with_gnuplot(const std::filesystem::path& directory, const std::string& name,
                              std::string_view script);

/// As a string constant of gnuplot's, in quotes; control characters become spaces.
std::string gnuplot_text(std::string_view text);

}  // namespace hystcan::app
