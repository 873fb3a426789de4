// What a DBC may have at most. Within these limits, time and memory grow in proportion to the file.
#pragma once

#include <cstddef>

namespace hystcan::can::dbc {

inline constexpr std::size_t largest_file = std::size_t{16} << 20U;  ///< 16 MiB
inline constexpr std::size_t longest_name = 1024;  ///< bytes of a name, a number, a unit, the name of a value
inline constexpr std::size_t longest_text = 65'536;  ///< bytes of a comment or of an attribute's value
inline constexpr std::size_t most_nodes = 65'536;
inline constexpr std::size_t most_messages = 65'536;
inline constexpr std::size_t most_signals = 65'536;  ///< of one message
inline constexpr std::size_t most_items = 65'536;  ///< of one list: receivers, names of values, ranges, items
inline constexpr std::size_t most_warnings = 1000;  ///< that are kept; all others are only counted

/// What one section says of several objects is copied to each: a comment of an identifier that several
/// messages have, the names of a value table. This bounds all copies together.
inline constexpr std::size_t largest_copies = std::size_t{64} << 20U;
inline constexpr std::size_t bytes_of_an_entry = 64;  ///< what each copy counts besides its text

}  // namespace hystcan::can::dbc
