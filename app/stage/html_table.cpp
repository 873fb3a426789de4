#include "app/stage/html_table.h"

#include <fmt/format.h>

namespace hystcan::app {

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  return safe;
}

std::string number_cell(const std::string& text, bool best) {
  return fmt::format("<td class=\"number{}\">{}</td>", best ? " best" : "", escaped(text));
}

std::string heading_row(const std::vector<std::string>& headings) {
  std::string row = "<tr>";
  for (std::size_t i = 0; i < headings.size(); ++i)
    row += fmt::format("<th{}>{}</th>", i == 0 ? "" : " class=\"number\"", escaped(headings[i]));
  return row + "</tr>\n";
}

}  // namespace hystcan::app
