#include "app/report/gnuplot.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <system_error>

#include "app/io/output_file.h"

namespace hystcan::app {
namespace {

std::string run_gnuplot(const std::filesystem::path& directory, const std::string& script) {
  const pid_t child = fork();
  if (child < 0) return std::generic_category().message(errno);
  if (child == 0) {
    std::signal(SIGPIPE, SIG_DFL);  // this program ignores it
    if (chdir(directory.c_str()) == 0) execlp("gnuplot", "gnuplot", script.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) return "gnuplot is not installed";
  return fmt::format("gnuplot failed at {}", script);
}

/// What gnuplot has left unfinished, and earlier plots of the same script.
void remove_plots_of(std::filesystem::path script) {
  std::error_code ignored;
  for (const char* ending : {".svg", ".png", ".pdf"})
    std::filesystem::remove(script.replace_extension(ending), ignored);
}

}  // namespace

std::string draw_with_gnuplot(const std::filesystem::path& directory, const std::string& name,
                              std::string_view script) {
  const std::filesystem::path path = directory / name;
  OutputFile file(path);
  file.write(script);
  file.commit();
  std::string failure = run_gnuplot(directory, name);
  if (!failure.empty()) remove_plots_of(path);
  return failure;
}

std::string gnuplot_text(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += c;
    quoted += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return quoted + "'";
}

}  // namespace hystcan::app
