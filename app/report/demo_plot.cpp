#include "app/report/demo_plot.h"

#include <fmt/format.h>

#include "app/report/gnuplot.h"
#include "app/report/plot_look.h"

namespace hystcan::app {
namespace {

constexpr PictureSize demo_size{.width_mm = 240.0, .height_mm = 190.0};

/// Rows of this axis while tracking; acting(drive): the drive whose effect the sample of this row shows, of some cycles before.
constexpr const char* demo_functions = R"(axis = {axis}
stroke = {stroke}
of(v) = (strcol('axis') eq axis && strcol('state') eq 'tracking' ? v : NaN)
acting(drive) = (strcol('axis') eq axis ? ({shifted}d0 = drive, {between}) : NaN)
)";

constexpr const char* demo_panels = R"(set multiplot layout 2,2 title {title}
set title 'The actuator: hysteresis'
set xlabel {drive}
set ylabel 'position (um)'
plot 'inverse+pi.csv' using (of(acting(column('drive')))):'position_um' with lines ls 2 dt 1 title 'measured'

set title 'Wanted against measured: before and after'
set xlabel 'reference (um)'
plot 'average.csv' using (of(column('reference_um'))):'position_um' with lines ls 5 title 'average (open loop)', \
     'inverse+pi.csv' using (of(column('reference_um'))):'position_um' with lines ls 1 title 'inverse+pi'

set title 'Tracking'
set xlabel 'time (s)'
set ylabel 'position (um)'
set xrange [{from}:{to}]
plot 'inverse+pi.csv' using (of(column('time_s'))):'reference_um' with lines ls 6 lw 2 title 'reference', \
     'pi.csv' using (of(column('time_s'))):'position_um' with lines ls 2 title 'pi', \
     'average+pi.csv' using (of(column('time_s'))):'position_um' with lines ls 3 title 'average+pi', \
     'inverse+pi.csv' using (of(column('time_s'))):'position_um' with lines ls 1 title 'inverse+pi'
set xrange [*:*]

set title 'Error'
set ylabel 'error (% of stroke)'
plot 'pi.csv' using (of(column('time_s'))):(100*column('error_um')/stroke) with lines ls 2 dt 1 title 'pi', \
     'average+pi.csv' using (of(column('time_s'))):(100*column('error_um')/stroke) with lines ls 3 dt 1 title 'average+pi', \
     'inverse+pi.csv' using (of(column('time_s'))):(100*column('error_um')/stroke) with lines ls 1 title 'inverse+pi'
unset multiplot
)";

/// acting() remembers the drives of the last cycles: d1 is that of the cycle before.
std::string functions(const DemoPlot& plot) {
  const auto whole = static_cast<std::size_t>(plot.delay_cycles);
  std::string shifted, nothing;
  for (std::size_t i = whole + 1; i > 0; --i) {
    shifted += fmt::format("d{} = d{}, ", i, i - 1);
    nothing += fmt::format("d{} = ", i);
  }
  const double part = plot.delay_cycles - static_cast<double>(whole);
  return fmt::format(demo_functions, fmt::arg("axis", gnuplot_string(plot.axis)),
                     fmt::arg("stroke", plot.stroke_um), fmt::arg("shifted", shifted),
                     fmt::arg("between",
                              fmt::format("{:.6f}*d{} + {:.6f}*d{}", 1.0 - part, whole, part, whole + 1))) +
         nothing + "d0 = NaN\n";
}

}  // namespace

std::string draw(const DemoPlot& plot) {
  const std::string body =
      fmt::format(demo_panels, fmt::arg("title", gnuplot_text(plot.title)),
                  fmt::arg("drive", gnuplot_text(fmt::format("drive ({})", plot.drive_unit))),
                  fmt::arg("from", plot.from_s), fmt::arg("to", plot.to_s));
  const std::vector<std::string> formats{"svg", "png"};
  return draw_with_gnuplot(plot.directory, "demo.gp", formats,
                           "# gnuplot demo.gp: draws demo.svg and demo.png\n" + functions(plot) +
                               drawn_as("demo", formats, demo_size, body));
}

}  // namespace hystcan::app
