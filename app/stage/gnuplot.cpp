#include "app/stage/gnuplot.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

#include "base/output_file.h"

namespace hystcan::app {
namespace {

constexpr double mm_per_inch = 25.4;
constexpr double svg_dots_per_inch = 96.0;
constexpr double png_dots_per_inch = 200.0;

std::string terminal(const std::string& format, const PictureSize& size) {
  const auto dots = [&](double per_inch) {
    return fmt::format("{:.0f},{:.0f}", size.width_mm / mm_per_inch * per_inch,
                       size.height_mm / mm_per_inch * per_inch);
  };
  if (format == "svg")
    return fmt::format("svg size {} enhanced background 'white' font 'sans-serif,11'",
                       dots(svg_dots_per_inch));
  if (format == "png")
    return fmt::format(
        "pngcairo size {} enhanced font 'sans-serif,9' fontscale {:g} linewidth {:g} pointscale 1.5",
        dots(png_dots_per_inch), png_dots_per_inch / svg_dots_per_inch,
        png_dots_per_inch / svg_dots_per_inch);
  return fmt::format("pdfcairo size {:g}cm,{:g}cm enhanced font 'sans-serif,9'", size.width_mm / 10.0,
                     size.height_mm / 10.0);
}

namespace fs = std::filesystem;

std::optional<std::string> run_gnuplot(const fs::path& directory, const std::string& script) {
  const pid_t child = fork();
  if (child < 0) return std::generic_category().message(errno);
  if (child == 0) {
    for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_DFL);  // this program ignores them
    setenv("LC_ALL", "C.UTF-8", 1);  // the encoding of the scripts, whatever the user's
    if (chdir(directory.c_str()) == 0) execlp("gnuplot", "gnuplot", ("./" + script).c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return std::nullopt;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) return "gnuplot is not installed";
  return fmt::format("gnuplot failed at {}", script);
}

fs::path picture_of(fs::path script, const std::string& ending) {
  return script.replace_extension("." + ending);
}

/// What gnuplot has left unfinished, and earlier pictures of the same script.
void remove_pictures_of(const fs::path& script, const std::vector<std::string>& endings) {
  std::error_code ignored;
  for (const std::string& ending : endings) fs::remove(picture_of(script, ending), ignored);
}

/// Whether the file has the last bytes of its format.
bool is_whole(const fs::path& picture, const std::string& ending) {
  constexpr std::streamoff tail_bytes = 16;
  std::ifstream file(picture, std::ios::binary);
  file.seekg(0, std::ios::end);
  file.seekg(std::max<std::streamoff>(0, file.tellg() - tail_bytes));
  const std::string tail{std::istreambuf_iterator<char>(file), {}};
  const char* last = ending == "svg" ? "</svg>" : ending == "png" ? "IEND" : "%%EOF";
  return tail.find(last) != std::string::npos;
}

}  // namespace

const std::vector<std::string>& picture_formats() {
  static const std::vector<std::string> formats{"svg", "png", "pdf"};
  return formats;
}

std::string plot_look() {
  return R"(set encoding utf8
set datafile separator ','
set datafile missing NaN
set border 3 lw 0.6
set tics nomirror out scale 0.6
set grid lw 0.4 lc rgb '#dddddd' dt 1
set key outside above center horizontal Left reverse samplen 2.5
set style line 1 lc rgb '#0072b2' lw 1.3 dt 1
set style line 2 lc rgb '#d55e00' lw 1.3 dt (9,3)
set style line 3 lc rgb '#009e73' lw 1.3 dt (3,3)
set style line 4 lc rgb '#cc79a7' lw 1.3 dt (9,3,3,3)
set style line 5 lc rgb '#999999' lw 1.3 dt 1
set style line 6 lc rgb '#000000' lw 1.0 dt 1
)";
}

std::string drawn_as(const std::string& name, const std::vector<std::string>& formats,
                     const PictureSize& size, const std::string& body) {
  std::string text = plot_look();
  for (const std::string& format : formats)
    text += fmt::format("\nset terminal {}\nset output {}\n{}unset output\n", terminal(format, size),
                        gnuplot_file(fmt::format("{}.{}", name, format)), body);
  return text;
}

std::optional<std::string> draw_with_gnuplot(const fs::path& directory, const std::string& name,
                                             const std::vector<std::string>& endings,
                                             std::string_view script) {
  const fs::path path = directory / name;
  write_file(path, script);
  remove_pictures_of(path, endings);
  std::optional<std::string> failure = run_gnuplot(directory, name);
  for (const std::string& ending : endings)
    if (!failure && !is_whole(picture_of(path, ending), ending))
      failure = fmt::format("gnuplot has not written the whole of {}; is the disk full?",
                            picture_of(name, ending).string());
  if (failure) remove_pictures_of(path, endings);
  return failure;
}

std::string gnuplot_string(std::string_view text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') result += c;
    result += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c;
  }
  return result + "'";
}

std::string gnuplot_text(std::string_view text) {
  std::string plain;
  for (const char c : text) {
    if (std::string_view("\\_^@&~{}").find(c) != std::string_view::npos) plain += '\\';
    plain += c;
  }
  return gnuplot_string(plain);
}

std::string gnuplot_file(std::string_view name) { return gnuplot_string(fmt::format("./{}", name)); }

std::string file_name_of(std::string_view text) {
  std::string name(text);
  for (char& c : name) {
    const bool is_letter_or_digit =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!is_letter_or_digit && std::string_view("._-+").find(c) == std::string_view::npos) c = '_';
  }
  if (name.empty() || name.front() == '.' || name.front() == '-') name.insert(0, "_");
  constexpr std::size_t longest = 100;
  return name.substr(0, longest);
}

}  // namespace hystcan::app
