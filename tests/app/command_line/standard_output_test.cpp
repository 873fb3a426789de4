// Standard output that cannot be written: a full disk, a closed stream, a pipe whose reader has ended.
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <string>
#include <vector>

#include "tests/app/command_line/cli.h"
#include "tests/support/long_run.h"

namespace hystcan::standard_output_test {
namespace {

// Redirections of the shell.
const std::string full_disk = "> /dev/full";
const std::string closed = ">&-";
const std::string no_reader = ">&4 4>&-";  // see StandardOutput::run

class StandardOutput : public Cli {
 protected:
  StandardOutput() {
    write("bus.log", "(1.500000) can0 081#0050200000000000\n(1.600000) can0 123#00\n");
    run("excite piezo.toml --output loops.csv --rehearse --period 0.5 --levels 2", "> /dev/null");
    run("excite piezo.toml --output steps.csv --rehearse --signal step", "> /dev/null");
  }

  /// Runs `hystcan ARGUMENTS` in the folder of the configuration. Descriptor 4 is a pipe without a reader.
  int run(const std::string& arguments, const std::string& redirection) {
    const std::string folder = shipped.folder().string();
    Process program({"sh", "-c",
                     "cd " + folder + " && rm -f pipe && mkfifo pipe && exec 3<>pipe 4>pipe 3>&- && exec " +
                         HYSTCAN_PROGRAM + " " + arguments + " " + redirection});
    const int status = program.wait();
    err_ = program.err();
    return status;
  }
  void fails_with_one_line(const std::string& arguments, const std::string& redirection,
                           const std::string& reason) {
    EXPECT_EQ(run(arguments, redirection), failed) << arguments << redirection << err_;
    const std::string line = "hystcan: standard output: cannot be written: " + reason + "\n";
    EXPECT_TRUE(err_.ends_with(line)) << arguments << redirection << err_;
    EXPECT_EQ(err_.find(line), err_.rfind("standard output") - 9) << arguments << err_;
  }

  /// Each computing command prints its result as text and as JSON. The form without a reader and the form
  /// with a closed stream change with the command.
  std::vector<std::string> half_of_results(std::size_t first) const {
    std::vector<std::string> half;
    for (std::size_t i = 0; i + 1 < results.size(); i += 2) half.push_back(results[i + (first + i / 2) % 2]);
    return half;
  }

  const std::vector<std::string> results{"identify loops.csv --output m.toml --overwrite",
                                         "identify loops.csv --output m.toml --overwrite --json",
                                         "validate piezo.model.toml loops.csv",
                                         "validate piezo.model.toml loops.csv --json",
                                         "tune piezo.toml --rehearse",
                                         "tune piezo.toml --rehearse --json",
                                         "demo --config piezo.toml --output out",
                                         "demo --config piezo.toml --output out --json",
                                         "doctor piezo.toml",
                                         "doctor piezo.toml --json"};
  const std::vector<std::string> streams{"--help",
                                         "--version",
                                         "identify --help",
                                         "check piezo.toml",
                                         "check piezo.model.toml",
                                         "decode bus.log --dbc hystcan.dbc",
                                         "decode bus.log --dbc hystcan.dbc --csv",
                                         "decode bus.log --dbc hystcan.dbc --json"};
  std::string err_;
};

TEST_F(StandardOutput, EndsEveryCommandWithAnErrorIfTheDiskIsFull) {
  for (const auto& commands : {support::long_run() ? results : half_of_results(1), streams})
    for (const std::string& command : commands)
      fails_with_one_line(command, full_disk, "No space left on device");
}

TEST_F(StandardOutput, EndsEveryCommandWithAnErrorIfClosed) {
  for (const auto& commands : {half_of_results(0), streams})
    for (const std::string& command : commands) fails_with_one_line(command, closed, "Bad file descriptor");
}

TEST_F(StandardOutput, EndsAResultWithAnErrorIfThereIsNoReader) {
  for (const std::string& command : half_of_results(1)) {
    EXPECT_EQ(run(command, no_reader), failed) << command << err_;
    EXPECT_NE(err_.find(": cannot be written: Broken pipe\n"), std::string::npos) << command << err_;
  }
}

TEST_F(StandardOutput, EndsAStreamWithZeroIfThereIsNoReader) {
  for (const std::string& command : streams) {
    EXPECT_EQ(run(command, no_reader), done) << command;
    EXPECT_EQ(err_, "") << command;
  }
}

TEST_F(StandardOutput, DoesNotChangeTheOutputFilesIfClosed) {
  EXPECT_EQ(run("tune piezo.toml --record steps.csv --output closed.toml", closed), failed);
  EXPECT_EQ(run("tune piezo.toml --record steps.csv --output open.toml", "> /dev/null"), done);
  EXPECT_EQ(read("closed.toml"), read("open.toml"));
}

TEST_F(StandardOutput, MayBeClosedForACommandWithoutAResult) {
  EXPECT_EQ(run("simulate piezo.model.toml --input loops.csv --output o.csv", closed), done) << err_;
  EXPECT_EQ(run("excite piezo.toml --output e.csv --rehearse", closed + " 2>&-"), done) << err_;
}

TEST_F(StandardOutput, EndsCtlWithAnErrorIfFull) {
  boost::asio::io_context context;
  using boost::asio::local::stream_protocol;
  stream_protocol::acceptor acceptor(context, stream_protocol::endpoint(path("twin.sock")));
  for (const std::string option : {"", "--json "}) {
    Process program({"sh", "-c",
                     std::string(HYSTCAN_PROGRAM) + " ctl " + option + "--timeout " + support::patience_s() +
                         " --socket " + path("twin.sock") + " remove > /dev/full"});
    stream_protocol::socket client = acceptor.accept();
    boost::asio::streambuf request;
    boost::asio::read_until(client, request, '\n');
    boost::asio::write(client, boost::asio::buffer(std::string("{\"ok\": true, \"removed\": 0}\n")));
    EXPECT_EQ(program.wait(), failed);
    EXPECT_EQ(program.err(), "hystcan: standard output: cannot be written: No space left on device\n");
  }
}

}  // namespace
}  // namespace hystcan::standard_output_test
