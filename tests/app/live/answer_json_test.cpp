// Each answer of the control socket is read as it was written.
#include "app/live/answer_json.h"

#include <gtest/gtest.h>

#include "tests/support/refusal.h"

namespace hystcan::app::answer_json_test {
namespace {

using nlohmann::json;

const json status = json::parse(R"({"ok": true, "time_s": 12.3, "age_s": 0.01, "cycles": 12345,
  "missed_cycles": 1, "missing_samples": 2, "late_samples": 3, "replaced_commands": 4,
  "timing": {"period_us": 1000.0, "lateness_us": 2.1, "turnaround_us": 31.5, "execution_us": 1.2},
  "recording": {"on": false, "run": "runs/r", "rows": 5, "rows_lost": 6, "bytes": 7, "failure": "disk full"},
  "last_event": {"text": "node 1: emergency 0x8130", "time_s": 3.25},
  "axes": [
    {"name": "x", "state": "tracking", "fault": "none", "position_um": 14.2131, "drive": 48.31,
     "amplifier_output": 48.29, "amplifier_output_age_s": null, "limits": "slew", "sample_missing": true,
     "reference_um": 14.2128, "error_um": -0.0003, "finished": true, "live_goal": true, "arrival": "in position",
     "learning": {"state": "resting", "periods": 8, "rms_um": 0.1, "first_rms_um": 0.2, "correction_um": 0.3,
                  "correction_max_um": 0.4}},
    {"name": "y", "state": "faulted", "fault": "sensor silent", "position_um": null, "drive": 0.0,
     "amplifier_output": 0.0, "amplifier_output_age_s": 0.1, "limits": "", "sample_missing": false,
     "fault_time_s": 3.5, "remedy": "look at its cable"},
    {"name": "z", "state": "waiting", "fault": "none", "position_um": 1.0, "drive": 0.0, "amplifier_output": 0.0,
     "amplifier_output_age_s": 0.1, "limits": "", "sample_missing": false, "waits_for": "a sample",
     "waits_for_all": ["a sample", "an amplifier output at rest"]}]})");

template <class T>
std::string written_again(const json& answer) {
  return answer_json(read_answer<T>(answer)).dump();
}

TEST(Answers, KeepEveryMemberOfAStatus) { EXPECT_EQ(written_again<StatusAnswer>(status), status.dump()); }

TEST(Answers, AreReadAsTheyAreWritten) {
  for (const Reply reply : every<Reply>())
    with_answer(reply, [](auto kind) {
      const json answer = answer_json(kind);
      EXPECT_EQ(written_again<decltype(kind)>(answer), answer.dump());
    });
}

TEST(Answers, KeepTheOptionalMembersOfATwinFault) {
  const json twin = json::parse(R"({"ok": true, "time_s": 1.0, "axes": [], "faults": [
    {"kind": "late", "axis": "x", "node": "sensor", "value": 3.0, "began_s": 0.5, "ends_s": 1.5},
    {"kind": "load_step", "axis": "y", "began_s": 0.25}]})");
  EXPECT_EQ(written_again<TwinStatusAnswer>(twin), twin.dump());
}

TEST(Answers, NameAMissingMember) {
  json without = status;
  without["axes"][1].erase("drive");
  EXPECT_EQ(support::refusal_of<RunError>([&] { read_answer<StatusAnswer>(without); }),
            "the answer has no \"axes[1].drive\"; the sender must have the same version of hystcan");
}

TEST(Answers, NameAMemberOfAnotherType) {
  json wrong = status;
  wrong["axes"][0]["state"] = "dancing";
  EXPECT_EQ(support::refusal_of<RunError>([&] { read_answer<StatusAnswer>(wrong); }),
            "\"axes[0].state\" of the answer is \"dancing\", expected one of the words that this version of "
            "hystcan has for this value; the sender must have the same version");
}

TEST(Answers, ThrowTheReasonOfARefusal) {
  EXPECT_EQ(
      support::refusal_of<RunError>([&] { read_answer<StatusAnswer>(refusal("the controller is ending")); }),
      "the controller is ending");
}

}  // namespace
}  // namespace hystcan::app::answer_json_test
