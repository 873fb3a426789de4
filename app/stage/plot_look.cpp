#include "app/stage/plot_look.h"

#include <fmt/format.h>

#include "app/stage/gnuplot.h"

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

}  // namespace hystcan::app
