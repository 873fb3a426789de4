#include "app/stage/model_words.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/stage/option_check.h"
#include "base/text.h"
#include "base/words.h"

namespace hystcan::app {
namespace {

CLI::Validator creep_or_auto() {
  return {[](const std::string& text) {
            const bool sound = text == "auto" || text == "none" ||
                               number_between(0.0, identification::most_creep_per_decade)(text).empty();
            return sound ? std::string()
                         : fmt::format("{}, expected auto, none or 0 to {:g}", text,
                                       identification::most_creep_per_decade);
          },
          "CREEP"};
}

CLI::Validator order_or_auto() {
  return {[](const std::string& text) {
            const bool sound = text == "auto" || whole_number(1, identification::highest_order)(text).empty();
            return sound ? std::string()
                         : fmt::format("{}, expected auto or 1 to {}", text, identification::highest_order);
          },
          "ORDER"};
}

}  // namespace

void ModelWords::apply_to(identification::IdentifyOptions& options) const {
  if (order != "auto") options.shape = identification::CurveShape::polynomial(*parsed_number<int>(order));
  options.curves = *parse_word<identification::CurveChoice>(curves);
  if (creep != "auto") options.creep_per_decade = creep == "none" ? 0.0 : *parsed_number<double>(creep);
}

void add_model_options(CLI::App& command, ModelWords& words) {
  add_checked(command, "--order", words.order, order_or_auto(),
              "order of polynomial reference curves, or auto (chosen by the error of held-out cycles)");
  add_checked(command, "--curves", words.curves, one_of({"auto", "polynomial", "spline"}),
              "polynomials, splines, or the better of both (auto)");
  add_checked(command, "--creep", words.creep, creep_or_auto(),
              "creep of the output per decade of time, as a fraction (example: 0.02); none; or auto "
              "(identified if creep lowers the error of held-out cycles)");
}

}  // namespace hystcan::app
