// Runs a Python file of this project (python/hystcan) as a child process, so that this program can use Python
// libraries.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan {

/// Returns the path of the file hystcan/NAME in the installed Python package or in the source tree. Returns
/// an empty path if the file is missing.
std::filesystem::path python_file(std::string_view name);

/// Runs hystcan/NAME.py as a child process. The interpreter is /usr/bin/python3, or the one in the
/// environment variable HYSTCAN_PYTHON. write() sends bytes to the standard input of the child, and read()
/// receives bytes from its standard output. finish() returns the last line of its standard error. Ctrl-C in
/// the terminal does not reach the child, because the child has its own process group. The child ends when
/// its input ends.
class PythonModule {
 public:
  /// `package`: the Debian package to install if Python is missing. The error message names this package.
  PythonModule(std::string_view name, std::vector<std::string> arguments, std::string_view package);
  ~PythonModule() { finish(); }
  PythonModule(const PythonModule&) = delete;
  PythonModule& operator=(const PythonModule&) = delete;

  /// Send bytes to the child and receive bytes from it. Return false if the child has ended or could not be
  /// started; finish() then returns the reason.
  bool write(std::string_view bytes);
  bool read(std::span<char> bytes);

  /// Closes the input of the child and waits until the child ends. If the child failed, returns the reason in
  /// one line.
  std::optional<std::string> finish();

 private:
  void start(const std::vector<std::string>& words);
  std::string last_message() const;

  std::string_view package_;
  pid_t child_ = -1;
  int stream_ = -1;    ///< socket that is connected to the child's standard input and output
  int messages_ = -1;  ///< file in memory that receives the child's standard error
  std::optional<std::string> failure_;
};

}  // namespace hystcan
