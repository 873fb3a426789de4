// A terminal's alternate screen, which is redrawn in place.
#pragma once

#include <termios.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::app {

/// The first `columns` characters of a line of UTF-8.
std::string_view cut(std::string_view line, std::size_t columns);

/// Reads single keys. The destructor restores the terminal.
class Screen {
 public:
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// What does not fit is cut off at the right and below.
  void show(const std::vector<std::string>& lines) const;
  /// True once the user has typed q.
  bool quit() const;

 private:
  termios before_{};
  bool keys_ = false;
};

}  // namespace hystcan::app
