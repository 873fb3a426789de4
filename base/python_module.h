// Python libraries for this program: a file of python/hystcan as a child process.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan {

/// hystcan/NAME of the Python package: where it is installed, or in the source tree. Empty if it is nowhere.
std::filesystem::path python_file(std::string_view name);

/// Runs hystcan/NAME.py by /usr/bin/python3, or by the interpreter that HYSTCAN_PYTHON names. Bytes go to its
/// standard input and arrive from its standard output; finish() returns the last line of its standard error.
/// Ctrl-C in the terminal is for this program: the child has a process group of its own, and ends with its
/// input.
class PythonModule {
 public:
  /// `package`: Debian's, which a message names if there is no Python.
  PythonModule(std::string_view name, std::vector<std::string> arguments, std::string_view package);
  ~PythonModule() { finish(); }
  PythonModule(const PythonModule&) = delete;
  PythonModule& operator=(const PythonModule&) = delete;

  /// False if the child has ended, or never started: finish() returns why.
  bool write(std::string_view bytes);
  bool read(std::span<char> bytes);

  /// Ends the input and waits for the child. Returns why it failed, in one line.
  std::optional<std::string> finish();

 private:
  void start(const std::vector<std::string>& words);
  std::string last_message() const;

  std::string_view package_;
  pid_t child_ = -1;
  int stream_ = -1;    ///< a socket, which the child has as its standard input and output
  int messages_ = -1;  ///< a file in memory: its standard error
  std::optional<std::string> failure_;
};

}  // namespace hystcan
