// Tables of a page in HTML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hystcan::app {

std::string escaped(std::string_view text);
/// The first heading is that of a text, the others are those of numbers.
std::string heading_row(const std::vector<std::string>& headings);
std::string number_cell(const std::string& text, bool best = false);

}  // namespace hystcan::app
