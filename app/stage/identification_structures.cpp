#include "app/stage/identification_structures.h"

#include <fmt/format.h>

#include <optional>

#include "app/stage/html_table.h"

namespace hystcan::app {
namespace {

using identification::Identified;
using identification::SearchResult;

class Structures {
 public:
  explicit Structures(const IdentificationReport& report)
      : report_(report), identified_(report.identified), percent_(100.0 / identified_.output_span) {}

  std::string text() const {
    const bool records = !identified_.left_out.empty();
    std::string part =
        "<h2>What carries over</h2>\n<table>\n" +
        heading_row({"structure", "fit RMS [%]",
                     records ? "records left out RMS [%]" : "held-out cycles RMS [%]", "taken"});
    for (const identification::Step& step : identified_.search.steps)
      part += row(step.what, step.rms_after, step.held_out_after, "yes");
    for (const identification::Step& step : identified_.search.refused)
      part += row(step.what, step.rms_after, step.held_out_after, "no");
    for (const identification::ShapeScore& tried : identified_.search.shapes)
      part += row(tried.shape.text(), tried.rms, tried.held_out,
                  tried.shape.text() == identified_.search.shape.text() ? "yes" : "no");
    if (identified_.other) {
      part += row(name_of(identified_.search), identified_.search.rms, identified_.search.held_out, "yes");
      part += row(name_of(*identified_.other), identified_.other->rms, identified_.other->held_out, "no");
    }
    return part + "</table>\n" + (records ? left_out() : std::string());
  }

 private:
  std::string row(const std::string& what, double rms, const std::optional<double>& held_out,
                  const char* taken) const {
    return fmt::format("<tr><td>{}</td>", escaped(what)) + number(rms) +
           (held_out ? number(*held_out) : number_cell("")) + number_cell(taken) + "</tr>\n";
  }
  std::string number(double error) const { return number_cell(fmt::format("{:.3g}", error * percent_)); }

  static std::string name_of(const SearchResult& result) {
    const double creep = result.trial.creep_per_decade;
    return creep > 0.0 ? fmt::format("all, with creep of {:.2g} % a decade", 100.0 * creep)
                       : "all, without creep";
  }

  std::string left_out() const {
    std::string part =
        "<table>\n" + heading_row({"record left out", "predicted by the others RMS [%]", "moves [%] more"});
    for (std::size_t i = 0; i < identified_.left_out.size(); ++i)
      if (const identification::LeftOut& of = identified_.left_out[i]; of.samples > 0.0)
        part += fmt::format("<tr><td>{}</td>", escaped(report_.names[i])) + number(of.rms()) +
                number_cell(fmt::format("{:+.2g}", 100.0 * (of.gain - 1.0))) + "</tr>\n";
    return part +
           "</table>\n<p class=\"note\">Each record predicted by the curves of the others, with its own zero and the "
           "mean gain of the others; k, thresholds, delay, creep and initial memories are those of all. Cycles beyond "
           "the inputs of the others do not count.</p>\n";
  }

  const IdentificationReport& report_;
  const Identified& identified_;
  double percent_;
};

}  // namespace

std::string structures_of(const IdentificationReport& report) {
  return report.identified.held_out_rms ? Structures(report).text() : std::string();
}

}  // namespace hystcan::app
