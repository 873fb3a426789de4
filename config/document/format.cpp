#include "config/document/format.h"

#include <fmt/format.h>

#include <cstdint>

#include "base/error.h"

namespace hystcan::config {

static_assert(newest_format == 1 && format_line == "format = 1\n");

void require_known_format(const toml::table& root, const std::string& name) {
  const toml::node* node = root.get("format");
  if (node == nullptr) return;
  const auto format = node->value_exact<std::int64_t>();
  const toml::source_position at = node->source().begin;
  const Place place{name, at.line, at.column};
  if (!format || *format < 1)
    throw Error(place, "format is not a positive whole number", {.expected = std::to_string(newest_format)});
  if (*format > newest_format)
    throw Error(place, fmt::format("format is {}, written for a newer hystcan", *format),
                expect("at most {}", newest_format));
}

}  // namespace hystcan::config
