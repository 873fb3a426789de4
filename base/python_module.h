// Runs a file of python/hystcan as a child process, so that this program can use Python libraries.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan {

/// Returns the path of hystcan/NAME in the Python package, installed or in the source tree; empty if there is
/// none.
std::filesystem::path python_file(std::string_view name);

/// Runs hystcan/NAME.py by /usr/bin/python3, or by the interpreter in HYSTCAN_PYTHON. write() sends bytes to
/// its standard input, read() receives bytes from its standard output, and finish() returns the last line of
/// its standard error. Ctrl-C in the terminal does not reach the child: it has its own process group, and
/// ends when its input ends.
class PythonModule {
 public:
  /// `package`: the Debian package that a message names if Python is missing.
  PythonModule(std::string_view name, std::vector<std::string> arguments, std::string_view package);
  ~PythonModule() { finish(); }
  PythonModule(const PythonModule&) = delete;
  PythonModule& operator=(const PythonModule&) = delete;

  /// Return false if the child has ended or never started; finish() then returns the reason.
  bool write(std::string_view bytes);
  bool read(std::span<char> bytes);

  /// Ends the input and waits for the child. Returns the reason in one line if it failed.
  std::optional<std::string> finish();

 private:
  void start(const std::vector<std::string>& words);
  std::string last_message() const;

  std::string_view package_;
  pid_t child_ = -1;
  int stream_ = -1;    ///< socket that is the child's standard input and output
  int messages_ = -1;  ///< file in memory that is the child's standard error
  std::optional<std::string> failure_;
};

}  // namespace hystcan
