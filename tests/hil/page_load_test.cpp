// Browsers on the operator's page do not delay the control loop: clients that read, and one that never reads.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/hil/live_stage.h"
#include "tests/hil/turnarounds.h"

namespace hystcan::page_load_test {
namespace {

using hil::json;
using hil::LiveStage;
using hil::Process;

constexpr int readers = 20;
constexpr int run_s = 2;

/// Returns the port in the line "page: http://127.0.0.1:PORT/" of the page's output; empty before that line
/// arrives.
std::string port_of(const std::string& output) {
  const std::string address = "page: http://127.0.0.1:";
  const auto begin = output.find(address);
  if (begin == std::string::npos || output.find('\n', begin) == std::string::npos) return {};
  return output.substr(begin + address.size(),
                       output.find('/', begin + address.size()) - begin - address.size());
}

struct Tracked {
  std::vector<double> turnarounds_us;
  json report;   ///< report of the controller
  json clients;  ///< data that each reader received; null without readers
};

/// Makes a first TCP connection in advance: in a freshly booted guest, the kernel occupies the only processor
/// for 12 ms during it.
void connect_once() {
  Process python({"/usr/bin/python3", "-I", "-S", "-c",
                  "import socket; server = socket.create_server(('127.0.0.1', 0)); "
                  "socket.create_connection(server.getsockname()).sendall(b'x')"});
  EXPECT_EQ(python.wait(), 0) << python.err();
}

Tracked track(bool with_clients) {
  Tracked run;
  LiveStage stage;
  stage.bench.controller_priority = hil::priority_over_nodes;
  const std::string log = stage.folder() + "/turnaround.log";
  stage.bench.candump = std::make_unique<Process>(
      std::vector<std::string>{"sh", "-c", "exec candump -L vcan0,182:7FF,201:7FF >" + log});
  stage.start({"--json"});
  std::optional<Process> page, clients;
  if (with_clients) {
    page.emplace(std::vector<std::string>{HYSTCAN_PROGRAM, "page", stage.config, "--listen", "127.0.0.1:0"});
    EXPECT_TRUE(hil::eventually([&] { return !port_of(page->out()).empty(); })) << page->err();
    clients.emplace(std::vector<std::string>{"/usr/bin/python3", "-I", "-S",
                                             HYSTCAN_SOURCE_DIR "/tests/hil/page_clients.py",
                                             port_of(page->out()), std::to_string(readers)});
    EXPECT_TRUE(clients->says("all connected")) << clients->err();
  }
  std::this_thread::sleep_for(std::chrono::seconds(run_s));
  if (clients) {
    clients->send(SIGTERM);
    EXPECT_EQ(clients->wait(), 0) << clients->err();
    run.clients = json::parse(clients->out());
  }
  run.report = stage.bench.stop_and_report(0);
  stage.bench.candump.reset();
  run.turnarounds_us = hil::turnarounds(log);
  return run;
}

TEST(IcountPage, TwentyClientsAndABlockedOneCostNoCycle) {
  connect_once();
  const Tracked quiet = track(false);
  const Tracked busy = track(true);
  ASSERT_GT(quiet.turnarounds_us.size(), 900U * run_s);
  ASSERT_GT(busy.turnarounds_us.size(), 900U * run_s);
  hil::print_turnarounds("alone", quiet.turnarounds_us);
  hil::print_turnarounds("clients", busy.turnarounds_us);
  const double ratio = hil::quantile(busy.turnarounds_us, 0.999) / hil::quantile(quiet.turnarounds_us, 0.999);
  std::printf("turnaround p99.9: with clients / alone = %.2f, aim 1.15: %s\n", ratio,
              ratio <= 1.15 ? "met" : "MISSED");

  // On one processor and without PREEMPT_RT the kernel itself may delay a cycle: its first TCP connection
  // takes 12.7 ms.
  const bool is_preemptible = std::filesystem::exists("/sys/kernel/realtime");
  std::printf("%d cycles missed\n", static_cast<int>(busy.report.at("missed_cycles")));
  EXPECT_LE(busy.report.at("missed_cycles"), is_preemptible ? 0 : 2);
  ASSERT_EQ(busy.clients.size(), std::size_t{readers});
  std::int64_t rows = 0, lost = 0;
  for (const json& client : busy.clients) {
    EXPECT_FALSE(client.at("cut_off")) << client.dump();
    EXPECT_GT(client.at("rows"), 0) << client.dump();
    rows += client.at("rows").get<std::int64_t>();
    lost += client.at("lost").get<std::int64_t>();
  }
  std::printf("%d clients: %ld rows received, %ld lost; %d samples missing\n", readers,
              static_cast<long>(rows), static_cast<long>(lost), busy.report.at("missing_samples").get<int>());
}

}  // namespace
}  // namespace hystcan::page_load_test
