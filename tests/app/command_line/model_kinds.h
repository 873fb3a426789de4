// A model file of each kind, for the tests of `simulate`.
#pragma once

#include <ostream>
#include <vector>

namespace hystcan {

#define HYSTCAN_UNITS "input_unit = \"V\"\noutput_unit = \"um\"\ninput_min = 0.0\ninput_max = 100.0\n"
#define HYSTCAN_CURVES                                                                                    \
  "basis = \"power\"\nascending = [0.0, 0.25, 4e-4, 1e-6]\ndescending = [0.8, 0.372, -8e-4]\nsymmetry = " \
  "\"none\"\n"

struct Kind {
  const char* name;
  const char* model;
  double input_tolerance = 1e-9;

  friend void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }
};

inline std::vector<Kind> every_kind(const char* recursive_memory) {
  return {
      {"RecursiveMemory", recursive_memory},
      {"Average", "[hysteresis]\nkind = \"average\"\n" HYSTCAN_UNITS HYSTCAN_CURVES},
      {"LinearMapping", "[hysteresis]\nkind = \"linear-mapping\"\n" HYSTCAN_UNITS HYSTCAN_CURVES},
      {"PrandtlIshlinskii", "[hysteresis]\nkind = \"prandtl-ishlinskii\"\n" HYSTCAN_UNITS
                            "offset = 0.5\ngain = 0.2\nthresholds = [2.0, 10.0]\nweights = [0.05, 0.04]\n"},
      // A Preisach branch starts with the small slope of the gain, so that the inverse is less exact.
      {"Preisach",
       "[hysteresis]\nkind = \"preisach\"\n" HYSTCAN_UNITS
       "offset = 0.5\ngain = 0.02\nweights = [3.0, 1.0, 4.0, 1.0, 2.0, 3.0]\n",
       1e-8}};
}

}  // namespace hystcan
