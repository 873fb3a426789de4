// The answers of a control socket. Each answer is a struct; its JSON object has the same members and `ok`. A
// `visit` function gives the name, unit and description of each member. An `optional` member is present only
// under the condition in its description. app/live/answer_json.h writes and reads the answers with `visit`,
// and the table of docs/control_socket.md is generated from it.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/live/control_protocol.h"
#include "config/schema/settings.h"
#include "controller/cycle_record.h"
#include "runs/run_writer.h"
#include "twin/fault.h"

namespace hystcan::app {

struct About {
  std::string_view unit;  ///< unit of the member; empty if it has none
  std::string_view meaning;
};

/// Marks a number that is missing. In JSON it is null.
inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

struct RefusedAnswer {
  std::string error;
  std::map<std::string, std::string> refusals{};  ///< reason of each axis that refused, by the axis's name
  std::string file{};
};
template <class V>
void visit(V& v, RefusedAnswer& a) {
  v.member("error", a.error, {"", "the reason"});
  v.optional(
      "refusals", a.refusals, !a.refusals.empty(),
      {"",
       "for programs: the reason of each axis that refused, as a name from `controller/control/refusal.h`"});
  v.optional("file", a.file, !a.file.empty(), {"", "the configuration file, if `settings` finds it invalid"});
}

struct DoneAnswer {
  std::vector<std::string> nothing_to_do{};
};
template <class V>
void visit(V& v, DoneAnswer& a) {
  v.optional("nothing_to_do", a.nothing_to_do, !a.nothing_to_do.empty(),
             {"", "each axis without a change, with the reason: `y: there is no fault to clear`"});
}

template <class V>
void visit(V& v, config::Change& a) {
  v.member("key", a.path, {"", "`axis[0].control.kp`"});
  v.member("from", a.from, {"", "previous value as TOML; empty: none"});
  v.member("to", a.to, {"", "new value as TOML; empty: none"});
}
template <class V>
void visit(V& v, config::Setting& a) {
  v.member("key", a.path, {"", "each key of the active configuration"});
  v.member("value", a.value, {"", "its value as TOML"});
}

struct ChangesAnswer {
  std::vector<config::Change> changed;
};
template <class V>
void visit(V& v, ChangesAnswer& a) {
  v.member("changed", a.changed, {"", "the keys whose value changed"});
}

struct SettingsAnswer {
  std::string file;
  std::vector<config::Setting> settings{};
  std::vector<config::Change> unsaved{};
  std::uint64_t undo = 0;
};
template <class V>
void visit(V& v, SettingsAnswer& a) {
  v.member("file", a.file, {"", "the configuration file"});
  v.member("settings", a.settings, {"", "the active configuration"});
  v.member("unsaved", a.unsaved,
           {"", "each key whose active value differs from its value in the file (`from`)"});
  v.member("undo", a.undo, {"", "number of `set` commands that `undo` can reverse"});
}

struct RunAnswer {
  std::string run;
};
template <class V>
void visit(V& v, RunAnswer& a) {
  v.member("run", a.run, {"", "the folder of the [run](runs.md)"});
}

struct PositionAnswer {
  double position_um = no_value;
};
template <class V>
void visit(V& v, PositionAnswer& a) {
  v.member("position_um", a.position_um, {"um", "position of the axis"});
}

template <class V>
void visit(V& v, controller::CycleCounters& a) {
  v.member("cycles", a.cycles, {"", "cycles of the controller since its start"});
  v.member("missed_cycles", a.missed_cycles, {"", "skipped cycles, because the computer was too slow"});
  v.member("missing_samples", a.missing_samples, {"", "cycles of active axes without a sample in time"});
  v.member("late_samples", a.late_samples, {"", "samples that arrived after the end of their cycle"});
  v.member("replaced_commands", a.replaced_commands,
           {"", "commands that a newer one replaced before transmission"});
}

struct TimingAnswer {
  double period_us = 0.0;
  double lateness_us = 0.0;
  double turnaround_us = 0.0;
  double execution_us = 0.0;
};
template <class V>
void visit(V& v, TimingAnswer& a) {
  v.member("period_us", a.period_us, {"us", "time from the previous SYNC to the SYNC of this cycle"});
  v.member("lateness_us", a.lateness_us, {"us", "delay of the SYNC after its scheduled time"});
  v.member("turnaround_us", a.turnaround_us,
           {"us", "time from the sample to the command; 0 without a sample"});
  v.member("execution_us", a.execution_us, {"us", "time to compute the command"});
}

template <class V>
void visit(V& v, runs::RunWriter::Status& a) {
  const bool has_run = !a.run.empty();
  v.member("on", a.is_recording, {"", "true during a recording"});
  v.optional("run", a.run, has_run, {"", "folder of the last [run](runs.md), if there is one"});
  v.optional("rows", a.rows, has_run, {"", "its rows"});
  v.optional("rows_lost", a.rows_lost, has_run, {"", "rows that could not be written to the disk"});
  v.optional("bytes", a.bytes, has_run, {"bytes", "size of the run's CSV files"});
  v.optional("failure", a.failure, !a.failure.empty(), {"", "reason, if the recording ended by itself"});
}

struct LastEvent {
  std::string text;
  double time_s = no_value;
};
template <class V>
void visit(V& v, LastEvent& a) {
  v.member("text", a.text, {"", "the event"});
  v.member("time_s", a.time_s, {"s", "time since the start"});
}

template <class V>
void visit(V& v, controller::Learning::Report& a) {
  v.member("state", a.state, {"", "`learning`, `resting`, `frozen`, `diverged`"});
  v.member("periods", a.periods, {"", "number of evaluated periods"});
  v.member("rms_um", a.rms_um, {"um", "RMS error in the last evaluated period of the reference"});
  v.member("first_rms_um", a.first_rms_um, {"um", "RMS error without learning"});
  v.member("correction_um", a.correction_um, {"um", "present correction"});
  v.member("correction_max_um", a.correction_max_um,
           {"um", "largest correction of the reference after the last evaluated period"});
}

struct AxisAnswer {
  std::string name;
  controller::AxisState state = controller::AxisState::offline;
  std::string fault{};
  double position_um = no_value;
  double drive = no_value;
  double amplifier_output = no_value;
  double amplifier_output_age_s = no_value;
  std::string limits{};
  bool sample_missing = false;
  std::string waits_for{};
  std::vector<std::string> waits_for_all{};
  double fault_time_s = no_value;
  std::string remedy{};
  double reference_um = no_value;
  double error_um = no_value;
  bool finished = false;
  bool live_goal = false;
  controller::Arrival arrival = controller::Arrival::not_judged;
  controller::Learning::Report learning{};

  bool tracks() const { return state == controller::AxisState::tracking; }
};
template <class V>
void visit(V& v, AxisAnswer& a) {
  const bool waits = !a.waits_for_all.empty(), has_fault = !a.remedy.empty();
  v.member("name", a.name, {"", "name in the configuration"});
  v.member("state", a.state,
           {"", "`offline`, `waiting`, `initialising`, `ready`, `tracking`, [`faulted`](safety.md)"});
  v.member("fault", a.fault, {"", "cause of the fault, or `none`"});
  v.member("position_um", a.position_um, {"um", "last measured position"});
  v.member("drive", a.drive, {"drive unit of the axis", "the commanded drive"});
  v.member("amplifier_output", a.amplifier_output,
           {"drive unit", "output in the amplifier's last status, which lags behind a moving drive"});
  v.member("amplifier_output_age_s", a.amplifier_output_age_s,
           {"s", "age of the amplifier's last status; null before the first status"});
  v.member("limits", a.limits, {"", "active limits of the drive, for example `slew+model`; empty: none"});
  v.member("sample_missing", a.sample_missing, {"", "true if the cycle had no sample"});
  v.optional("waits_for", a.waits_for, waits, {"", "first missing condition, if the axis waits for one"});
  v.optional(
      "waits_for_all", a.waits_for_all, waits,
      {"",
       "missing conditions: for each node only the first, because its later conditions depend on the first. "
       "A ready amplifier can have two: its output is out of range, and its output changes"});
  v.optional("fault_time_s", a.fault_time_s, has_fault,
             {"s", "faulted axis: time from the start of the controller to the fault"});
  v.optional("remedy", a.remedy, has_fault, {"", "faulted axis: what to do"});
  v.optional("reference_um", a.reference_um, a.tracks(), {"um", "while tracking: the reference"});
  v.optional("error_um", a.error_um, a.tracks(), {"um", "while tracking: reference - position"});
  v.optional("finished", a.finished, a.tracks(), {"", "while tracking: true at the end of the reference"});
  v.optional("live_goal", a.live_goal, a.tracks(),
             {"", "while tracking: true if the axis follows `go_to` and not the configured reference"});
  v.optional("arrival", a.arrival, a.tracks(),
             {"",
              "while tracking: `not judged`, `moving`, `in position`, `failed` "
              "([meaning](configuration/loop.md#axiscontrolin_position-has-the-stage-arrived))"});
  v.optional("learning", a.learning, a.learning.state != controller::LearningState::off,
             {"", "while tracking: progress of the learning, if `[axis.control.learning]` is configured"});
}

struct StatusAnswer {
  double time_s = no_value;
  double age_s = no_value;
  controller::CycleCounters counters{};
  TimingAnswer timing{};
  runs::RunWriter::Status recording{};
  std::optional<LastEvent> last_event{};
  std::vector<AxisAnswer> axes{};
};
template <class V>
void visit(V& v, StatusAnswer& a) {
  v.member("time_s", a.time_s, {"s", "time from the start of the controller to the newest cycle"});
  v.member("age_s", a.age_s,
           {"s",
            "age of the newest cycle, usually less than 0.02 s; "
            "if this age grows, no cycles run, and all other values are as old"});
  visit(v, a.counters);
  v.member("timing", a.timing, {"", "times of the newest cycle"});
  v.member("recording", a.recording, {"", "the recording"});
  v.optional(
      "last_event", a.last_event, a.last_event.has_value(),
      {"",
       "last event of a node: an emergency, a failed set-up, an NMT command or SDO of another device, "
       "a sample with a wrong SYNC counter, a frame outside its slot, or a frame of another controller"});
  v.member("axes", a.axes, {"", "the newest cycle of each axis"});
}

struct FaultAnswer {
  std::string fault;
};
template <class V>
void visit(V& v, FaultAnswer& a) {
  v.member("fault", a.fault, {"", "description of the injected fault"});
}

struct RemovedAnswer {
  std::uint64_t removed = 0;
};
template <class V>
void visit(V& v, RemovedAnswer& a) {
  v.member("removed", a.removed, {"", "number of faults removed"});
}

struct TwinAxisAnswer {
  std::string name;
  std::string amplifier{};
  std::uint64_t amplifier_fault = 0;
  std::string sensor{};
  double drive = no_value;
  double position_um = no_value;
};
template <class V>
void visit(V& v, TwinAxisAnswer& a) {
  v.member("name", a.name, {"", "name in the configuration"});
  v.member("amplifier", a.amplifier, {"", "`off`, `ready`, `enabled`, `tripped`"});
  v.member("amplifier_fault", a.amplifier_fault, {"", "fault flags in the status of the amplifier"});
  v.member("sensor", a.sensor, {"", "`off`, `pre-operational`, `operational`, `stopped`"});
  v.member("drive", a.drive, {"drive unit", "true drive, including noise and ripple"});
  v.member("position_um", a.position_um, {"um", "true position"});
}

struct TwinFaultAnswer {
  twin::Fault kind = twin::Fault::no_reply;
  std::string axis{};
  std::optional<twin::Node> node{};
  std::optional<double> value{};
  double began_s = no_value;
  std::optional<double> ends_s{};
};
template <class V>
void visit(V& v, TwinFaultAnswer& a) {
  v.member("kind", a.kind, {"", "[kind of the fault](twin.md#faults)"});
  v.member("axis", a.axis, {"", "its axis"});
  v.optional("node", a.node, a.node.has_value(),
             {"", "`sensor` or `amplifier`; missing for a fault of the stage"});
  v.optional("value", a.value, a.value.has_value(),
             {"", "strength of the fault, in the [unit of its kind](twin.md#faults)"});
  v.member("began_s", a.began_s, {"s", "start of the fault, since the start of the twin"});
  v.optional("ends_s", a.ends_s, a.ends_s.has_value(),
             {"s", "end of the fault, since the start of the twin; only if the fault has a duration"});
}

struct TwinStatusAnswer {
  double time_s = no_value;
  std::vector<TwinAxisAnswer> axes{};
  std::vector<TwinFaultAnswer> faults{};
};
template <class V>
void visit(V& v, TwinStatusAnswer& a) {
  v.member("time_s", a.time_s, {"s", "time since the start of the twin"});
  v.member("axes", a.axes, {"", "each axis"});
  v.member("faults", a.faults, {"", "each active fault"});
}

/// Calls `use` with an empty answer struct of the type that `reply` selects. A generic `use` reads only the
/// type of its argument. Does nothing for Reply::none.
template <class Use>
void with_answer(Reply reply, Use use) {
  if (reply == Reply::done) use(DoneAnswer{});
  if (reply == Reply::changes) use(ChangesAnswer{});
  if (reply == Reply::run) use(RunAnswer{});
  if (reply == Reply::position) use(PositionAnswer{});
  if (reply == Reply::fault) use(FaultAnswer{});
  if (reply == Reply::count) use(RemovedAnswer{});
  if (reply == Reply::keys) use(SettingsAnswer{});
  if (reply == Reply::states) use(StatusAnswer{});
  if (reply == Reply::twin_states) use(TwinStatusAnswer{});
}

}  // namespace hystcan::app
