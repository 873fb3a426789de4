// The program as a process: its output, files and exit status.
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <istream>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/app/command_line/cli.h"

namespace hystcan::cli_test {
namespace {

TEST_F(Cli, ADurationMustBeATime) {
  for (const char* duration : {"0", "-1", "nan", "inf", "1e300", "soon"}) {
    Process program({HYSTCAN_PROGRAM, "controller", path("piezo.toml"), "--duration", duration});
    EXPECT_EQ(program.wait(), bad_input) << duration;
  }
}

TEST_F(Cli, CheckWarnsIfTwinAndControllerDifferInInterpolation) {
  const std::string warning = "# warning: axis x: the twin has interpolate = true";
  shipped.edit("piezo.toml", "safe_drive_V       = 0.0\nslew_V_per_s       = 93_000.0",
               "interpolate = true\nsafe_drive_V       = 0.0\nslew_V_per_s       = 93_000.0");
  Process disagreeing({HYSTCAN_PROGRAM, "check", path("piezo.toml")});
  EXPECT_EQ(disagreeing.wait(), done) << disagreeing.err();
  EXPECT_NE(disagreeing.out().find(warning), std::string::npos) << disagreeing.out();
  shipped.edit("piezo.toml", "resonance_Hz           = 500.0", "interpolated = true\nresonance_Hz = 500.0");
  Process agreeing({HYSTCAN_PROGRAM, "check", path("piezo.toml")});
  EXPECT_EQ(agreeing.wait(), done) << agreeing.err();
  EXPECT_EQ(agreeing.out().find(warning), std::string::npos) << agreeing.out();
}

TEST_F(Cli, CheckPrintsTheValuesInForce) {
  Process program({HYSTCAN_PROGRAM, "check", path("piezo.toml")});
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find("heartbeat_timeout_ms = 300  # default"), std::string::npos);
  EXPECT_NE(program.out().find("previewed by"), std::string::npos);
  EXPECT_NE(program.out().find("# axis y: k_descending = "), std::string::npos) << program.out();
}

TEST_F(Cli, CheckPrintsTheRatesOfAnOverloadedBus) {
  shipped.edit("piezo.toml", "bitrate_bit_per_s = 1_000_000",
               "bitrate_bit_per_s = 500_000\ndata_bitrate_bit_per_s = 2_000_000");
  Process program({HYSTCAN_PROGRAM, "check", "--rates", "--json", path("piezo.toml")});
  EXPECT_EQ(program.wait(), done) << program.err();
  const auto rates = nlohmann::json::parse(program.out());
  EXPECT_EQ(rates.at("bitrate_bit_per_s"), 500'000);
  EXPECT_EQ(rates.at("data_bitrate_bit_per_s"), 2'000'000);
  ASSERT_EQ(rates.at("rows").size(), 16U);
  for (const auto& row : rates.at("rows")) {
    const double classical = row.at("classical").at("rate_Hz"), fd = row.at("fd").at("rate_Hz");
    EXPECT_LT(classical, fd);
    EXPECT_LE(fd, row.at("fd_shared").at("rate_Hz"));
    EXPECT_LT(row.at("fd_shared").at("rate_Hz"), row.at("fd_slots").at("rate_Hz"));
    EXPECT_LE(row.at("fd").at("response_us"), 1e6 / fd);
  }
}

TEST_F(Cli, CheckPrintsTheAllowedRangeOfKAndItsEndsAreAccepted) {
  Process program({HYSTCAN_PROGRAM, "check", path("piezo.model.toml")});
  EXPECT_EQ(program.wait(), done) << program.err();
  const std::string line = program.out().substr(program.out().find("k_ascending = "));
  double lo = 0.0, hi = 0.0;
  ASSERT_EQ(std::sscanf(line.c_str(), "k_ascending = 0.035 1/V; %lf to %lf is allowed", &lo, &hi), 2) << line;
  for (const double end : {lo, hi}) {
    char text[64];
    std::snprintf(text, sizeof text, "k_ascending  = %.6g", end);
    const support::ShippedCopy copy;
    copy.edit("piezo.model.toml", "k_ascending  = 0.035", text);
    Process again({HYSTCAN_PROGRAM, "check", (copy / "piezo.model.toml").string()});
    EXPECT_EQ(again.wait(), done) << again.err();
  }
}

// UTF-16, and CR alone as line end, are named as such instead of a mistake in the first line. The byte order
// mark of UTF-8 is accepted.
TEST_F(Cli, NamesTheEncodingOfAFileThatItCannotRead) {
  const std::string log = "(1700000000.000000) vcan0 080#\n(1700000000.001000) vcan0 080#\n";
  const std::string cycles = "cycle,time_s,axis,state,position_um\n1,0.001,x,tracking,1.5\n";
  const std::map<std::string, std::pair<std::string, std::vector<std::string>>> files{
      {"a.toml", {read("piezo.model.toml"), {"check", path("a.toml")}}},
      {"a.csv",
       {"time_s,input\n0,0\n0.001,1\n",
        {"simulate", path("piezo.model.toml"), "--input", path("a.csv"), "--output", path("out.csv")}}},
      {"a.log", {log, {"decode", path("a.log"), "--dbc", path("hystcan.dbc")}}},
      {"cycles.csv", {cycles, {"export", path("cycles.csv")}}}};
  for (const auto& [name, file] : files) {
    const auto& [text, arguments] = file;
    std::vector<std::string> command{HYSTCAN_PROGRAM};
    command.insert(command.end(), arguments.begin(), arguments.end());
    std::string utf16 = "\xFF\xFE", macintosh = text;
    for (const char c : text) utf16 += {c, '\0'};
    std::ranges::replace(macintosh, '\n', '\r');
    for (const auto& [written, expected] : std::map<std::string, std::string>{
             {utf16, "found UTF-16, expected UTF-8"}, {macintosh, "found lines that end with CR alone"}}) {
      write(name.c_str(), written);
      Process refused(command);
      EXPECT_EQ(refused.wait(), bad_input) << name;
      EXPECT_NE(refused.err().find(name + ":1"), std::string::npos) << refused.err();
      EXPECT_NE(refused.err().find(expected), std::string::npos) << refused.err();
    }
    write(name.c_str(), "\xEF\xBB\xBF" + text);
    Process read_well(command);
    EXPECT_EQ(read_well.wait(), done) << name << read_well.err();
  }
}

// A file receives the raw text, as with ls.
TEST_F(Cli, PrintsNoControlCharacterOfARunToATerminal) {
  std::filesystem::create_directory(shipped / "run_1");
  write("run_1/cycles_0001.csv",
        "cycle,time_s,axis,state,position_um\n1,0.001,x\x1b]0;moved\x07,tracking,1.5\n");
  write("run_1/run.json",
        R"({"hystcan_run": 1, "version": "", "host": "", "command": "", "config": "\u001b[2J",
    "interface": "", "rate_Hz": 0, "started": "", "ended": "", "failure": "", "first_s": 0, "last_s": 0, "rows": 0,
    "rows_lost": 0, "axes": [], "settings": []})");
  Process terminal({"script", "--quiet", "--return", "--command",
                    HYSTCAN_PROGRAM " runs " + shipped.folder().string(), "/dev/null"});
  EXPECT_EQ(terminal.wait(), done);
  EXPECT_NE(terminal.out().find("x\\x1b]0;moved\\x07"), std::string::npos) << terminal.out();
  EXPECT_EQ(terminal.out().find('\x1b'), std::string::npos) << terminal.out();
  Process file({HYSTCAN_PROGRAM, "runs", shipped.folder().string()});
  EXPECT_EQ(file.wait(), done);
  EXPECT_NE(file.out().find("x\x1b]0;moved\x07"), std::string::npos) << file.out();
}

TEST_F(Cli, CheckReportsAMistakeInOneLineWithItsPlace) {
  shipped.edit("piezo.toml", "rate_Hz", "rate_hz");
  Process program({HYSTCAN_PROGRAM, "check", path("piezo.toml")});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_EQ(std::ranges::count(program.err(), '\n'), 1);
  EXPECT_NE(
      program.err().find("piezo.toml:16:1: unknown key rate_hz (did you mean rate_Hz?), expected one of "),
      std::string::npos)
      << program.err();
}

TEST_F(Cli, CtlPrintsTheNumberOfRemovedFaults) {
  boost::asio::io_context context;
  using boost::asio::local::stream_protocol;
  stream_protocol::acceptor acceptor(context, stream_protocol::endpoint(path("twin.sock")));
  const auto print = [&](const char* command, const std::string& answer) {
    Process program(
        {HYSTCAN_PROGRAM, "ctl", "--socket", path("twin.sock"), "--timeout", support::patience_s(), command});
    stream_protocol::socket client = acceptor.accept();
    boost::asio::streambuf request;
    boost::asio::read_until(client, request, '\n');
    std::istream line(&request);
    EXPECT_EQ(nlohmann::json::parse(line), (nlohmann::json{{"do", command}}));
    boost::asio::write(client, boost::asio::buffer(answer + "\n"));
    EXPECT_EQ(program.wait(), done) << program.err();
    return program.out();
  };
  EXPECT_EQ(print("remove", R"({"ok": true, "removed": 0})"), "0 faults removed\n");
  EXPECT_EQ(print("remove", R"({"ok": true, "removed": 1})"), "1 fault removed\n");
}

TEST_F(Cli, CtlGivesUpAfterItsTimeout) {
  boost::asio::io_context context;
  using boost::asio::local::stream_protocol;
  const stream_protocol::acceptor silent(context, stream_protocol::endpoint(path("silent.sock")));
  Process program({HYSTCAN_PROGRAM, "ctl", "--socket", path("silent.sock"), "--timeout", "0.1", "stop"});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_EQ(program.err(),
            "hystcan: " + path("silent.sock") +
                ": no answer within 0.1 s (--timeout); the controller does not read its socket\n");
}

TEST_F(Cli, DemoComparesOpenLoopAndClosedLoop) {
  Process program({HYSTCAN_PROGRAM, "demo", "--config", path("piezo.toml"), "--output", path("out")});
  ASSERT_EQ(program.wait(), done) << program.err();
  for (const char* text :
       {"\naverage ", "\ninverse+pi ", "\npromise x: ",
        "\ntrue RMS error: 1.504 um in open loop (average), 0.036 um with inverse+pi: 41.8 times smaller\n"})
    EXPECT_NE(program.out().find(text), std::string::npos) << text << program.out();
  EXPECT_EQ(program.out().find("\npi "), std::string::npos) << program.out();
  for (const char* file : {"out/demo.svg", "out/average.csv", "out/inverse+pi.csv"})
    EXPECT_GT(std::filesystem::file_size(shipped / file), 10'000u) << file;
  EXPECT_FALSE(std::filesystem::exists(shipped / "out/pi.csv"));
}

TEST_F(Cli, DemoComparesAnOpenLoopWithTheClosedLoop) {
  shipped.edit("soft_stage.toml", "structure          = \"inverse+pi\"", "structure          = \"average\"");
  Process program(
      {HYSTCAN_PROGRAM, "demo", "--config", path("soft_stage.toml"), "--output", path("out"), "--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto columns = nlohmann::json::parse(program.out()).at("columns");
  ASSERT_EQ(columns.size(), 2u);
  EXPECT_EQ(columns[0].at("structure"), "average");
  EXPECT_EQ(columns[1].at("structure"), "inverse+pi");
}

TEST_F(Cli, DemoPrintsFiveColumnsWithAllAndWritesPlotAndCsv) {
  Process program(
      {HYSTCAN_PROGRAM, "demo", "--all", "--config", path("piezo.toml"), "--output", path("out"), "--json"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const auto json = nlohmann::json::parse(program.out());
  EXPECT_EQ(json.at("rate_hz"), 1000.0);
  ASSERT_EQ(json.at("columns").size(), 5u);
  EXPECT_EQ(json.at("columns")[4].at("structure"), "inverse+pi");
  EXPECT_LT(json.at("columns")[4].at("rms_percent"), 0.12);
  EXPECT_GT(json.at("columns")[2].at("rms_percent"), 3.0);
  const auto& truth = json.at("columns")[4].at("true").at("segments").at(0);
  EXPECT_GT(truth.at("samples"), 10'000) << "every 50 us of 0.9 s";
  EXPECT_GT(truth.at("rms_um"), json.at("floors_um").at(0)) << "of the triangle";
  EXPECT_TRUE(json.at("floors_um").at(1).is_null()) << "the staircase does not repeat";
  for (const char* file : {"out/demo.svg", "out/demo.png", "out/inverse+pi.csv", "out/inverse+pi.truth.csv"})
    EXPECT_GT(std::filesystem::file_size(shipped / file), 10'000u) << file;
}

TEST_F(Cli, ControllerWritesNoFileBeforeTheBusIsOpen) {
  const std::string before = read("piezo.toml");
  Process onto_itself({HYSTCAN_PROGRAM, "controller", path("piezo.toml"), "--csv", path("piezo.toml")});
  EXPECT_EQ(onto_itself.wait(), bad_input);
  EXPECT_EQ(read("piezo.toml"), before);
  write("run.csv", "precious");
  Process no_bus(
      {HYSTCAN_PROGRAM, "controller", path("piezo.toml"), "--interface", "nocan7", "--csv", path("run.csv")});
  EXPECT_EQ(no_bus.wait(), failed);
  EXPECT_EQ(read("run.csv"), "precious");
}

/// The expected output of a user without a bus: the log, the file of cycles and the exit status of a real
/// run.
TEST_F(Cli, RehearsalWithTwinFaultsIsRepeatable) {
  shipped.edit("piezo.toml", "[[axis]]",
               "[[twin.fault]]\nkind = \"no_reply\"\naxis = \"x\"\nat_s = 1.0\nduration_s = 0.1\n\n[[axis]]");
  std::string first;
  for (const char* csv : {"first.csv", "second.csv"}) {
    Process program({HYSTCAN_PROGRAM, "controller", path("piezo.toml"), "--rehearse", "--csv", path(csv)});
    EXPECT_EQ(program.wait(), failed);
    EXPECT_NE(program.err().find("[info] 1.000 s: twin: sensor of x: no_reply begins\n"), std::string::npos)
        << program.err();
    EXPECT_NE(program.err().find("[error] 1.004 s: x: faulted at 1.003 s: sample missing; "),
              std::string::npos)
        << program.err();
    if (first.empty()) first = program.err();
    EXPECT_EQ(program.err(), first);
  }
  EXPECT_EQ(read("first.csv"), read("second.csv"));
}

TEST_F(Cli, ControllerContinuesIfItsFileReachesTheSizeLimit) {
  Process program({"sh", "-c",
                   std::string("ulimit -f 8; exec " HYSTCAN_PROGRAM " controller ") + path("piezo.toml") +
                       " --rehearse --csv " + path("run.csv")});
  EXPECT_EQ(program.wait(), failed) << program.err();
  EXPECT_NE(program.out().find("RMS"), std::string::npos) << program.out();
  EXPECT_NE(program.err().find("File too large"), std::string::npos) << program.err();
}

/// Otherwise virtual time would pass forever, unnoticed.
TEST_F(Cli, RehearsalEndsWithTheReasonIfNoAxisStarts) {
  shipped.edit("soft_stage.toml", "[[axis]]",
               "[[twin.fault]]\nkind = \"no_reply\"\naxis = \"x\"\nat_s = 0.0\nduration_s = 1e6\n\n[[axis]]");
  Process program({HYSTCAN_PROGRAM, "controller", path("soft_stage.toml"), "--rehearse"});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("hystcan: nothing was tracked: x waited for a sample (node 2)"),
            std::string::npos)
      << program.err();
}

TEST_F(Cli, RehearsalRefusesOptionsOfARealBus) {
  for (const char* option : {"--interface=vcan0", "--record=runs", "--clear-faults"}) {
    Process program({HYSTCAN_PROGRAM, "controller", path("piezo.toml"), "--rehearse", option});
    EXPECT_EQ(program.wait(), bad_input) << option;
  }
}

TEST_F(Cli, DemoContinuesAfterAFaultAndExitsWithOne) {
  shipped.edit(
      "piezo.toml", "[[axis]]",
      "[[twin.fault]]\nkind = \"amplifier_trip\"\naxis = \"x\"\nat_s = 1.0\nduration_s = 0.1\n\n[[axis]]");
  Process program(
      {HYSTCAN_PROGRAM, "demo", "--all", "--config", path("piezo.toml"), "--output", path("out"), "--json"});
  EXPECT_EQ(program.wait(), failed);
  const auto json = nlohmann::json::parse(program.out());
  ASSERT_EQ(json.at("columns").size(), 5u);
  for (const auto& column : json.at("columns")) {
    const std::string name = column.at("structure");
    const std::string failure = column.at("failure");
    EXPECT_TRUE(failure.starts_with("axis x faulted at ")) << failure;
    EXPECT_NE(program.err().find("hystcan: " + name + ": " + failure + "\n"), std::string::npos)
        << program.err();
    EXPECT_TRUE(std::filesystem::exists(shipped / ("out/" + name + ".csv").c_str())) << name;
  }
}

TEST_F(Cli, DemoReportsMissingPythonAndContinues) {
  Process program({"env", "HYSTCAN_PYTHON=/nonexistent", HYSTCAN_PROGRAM, "demo", "--config",
                   path("piezo.toml"), "--output", path("out")});
  EXPECT_EQ(program.wait(), done);
  EXPECT_NE(program.err().find("no picture: /nonexistent cannot be started"), std::string::npos)
      << program.err();
  EXPECT_FALSE(std::filesystem::exists(shipped / "out/demo.svg"));
}

TEST_F(Cli, DemoRemovesTheFilesOfTheRunThatASignalStops) {
  shipped.edit("piezo.toml", "cycles       = 10.0", "cycles       = 10000.0");
  Process program({HYSTCAN_PROGRAM, "demo", "--config", path("piezo.toml"), "--output", path("out")});
  ASSERT_TRUE(support::eventually(
      [&] { return std::filesystem::exists(shipped / "out/average.csv") || !program.running(); }));
  program.send(SIGINT);
  EXPECT_EQ(program.wait(), failed);
  EXPECT_EQ(program.err(), "hystcan: stopped before the end of the comparison\n");
  EXPECT_TRUE(std::filesystem::is_empty(shipped / "out"));
}

TEST_F(Cli, DemoFailsIfAnAxisNeverTracks) {
  shipped.edit("piezo.toml", "wipe_slew_V_per_s  = 500.0 ", "wipe_slew_V_per_s  = 1e-3 ");
  Process program({HYSTCAN_PROGRAM, "demo", "--config", path("piezo.toml"), "--output", path("out")});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("axis x did not start to track"), std::string::npos) << program.err();
}

}  // namespace
}  // namespace hystcan::cli_test
