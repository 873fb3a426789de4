// The log on a pipe whose reader is late or never reads.
#include "base/log_sink.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "base/standard_streams.h"
#include "tests/support/shipped.h"

namespace hystcan::app::log_sink_test {
namespace {

class Pipe {
 public:
  Pipe() {
    EXPECT_EQ(pipe2(ends_.data(), O_CLOEXEC), 0);
    EXPECT_GT(fcntl(ends_[1], F_SETPIPE_SZ, 4096), 0);
  }
  ~Pipe() {
    close_reader();
    close_writer();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int writer() const { return ends_[1]; }
  void close_reader() { close_end(0); }
  void close_writer() { close_end(1); }
  /// Reads until the text ends with `last`, or to the end, after the writer has closed.
  std::string read_up_to(std::string_view last) const {
    std::string text;
    std::array<char, 4096> chunk{};
    for (ssize_t got = 0; !text.ends_with(last) && (got = read(ends_[0], chunk.data(), chunk.size())) > 0;)
      text.append(chunk.data(), static_cast<std::size_t>(got));
    return text;
  }

 private:
  void close_end(std::size_t which) {
    if (ends_[which] >= 0) close(ends_[which]);
    ends_[which] = -1;
  }

  std::array<int, 2> ends_{-1, -1};
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::shared_ptr<spdlog::logger> logger_on(int descriptor) {
  auto logger = std::make_shared<spdlog::logger>("test", std::make_shared<LogSink>(descriptor));
  logger->set_pattern("%v");
  return logger;
}

/// Returns the content of a file after flush() and after the end of the sink.
struct LoggedFile {
  LoggedFile() {
    const support::ScratchFolder folder;
    const std::string file = folder / "log";
    const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    auto logger = logger_on(descriptor);
    for (int i = 0; i < 500; ++i) {
      logger->info("line {}", i);
      expected += "line " + std::to_string(i) + "\n";
    }
    logger->flush();
    flushed = support::read_file(file);
    logger->info("the last one");
    logger.reset();
    ended = support::read_file(file);
    close(descriptor);
  }
  bool is_whole() const { return flushed == expected && ended == expected + "the last one\n"; }

  std::string expected, flushed, ended;
};

// flush() and the end wait half a second for a line. The sink's thread yields to all others: a busy machine
// may give it no time, so there are three attempts.
TEST(LogSink, WritesLinesInTheirOrder) {
  LoggedFile file;
  for (int attempt = 0; attempt < 2 && !file.is_whole(); ++attempt) file = {};
  EXPECT_EQ(file.flushed, file.expected);
  EXPECT_EQ(file.ended, file.expected + "the last one\n") << "its end writes the rest";
}

/// The lines "line 0", "line 1", ... that arrived, and the lines reported as lost, must be all logged lines.
std::size_t lines_accounted_for(const std::string& text) {
  std::size_t next = 0;
  for (const std::string& line : lines_of(text)) {
    std::size_t lost = 0;
    if (std::sscanf(line.c_str(), "[hystcan] [warning] %zu", &lost) == 1)
      next += lost;
    else
      EXPECT_EQ(line, "line " + std::to_string(next++));
  }
  return next;
}

TEST(LogSink, DoesNotWaitForItsReaderAndReportsLostLines) {
  constexpr std::size_t logged = 5000;
  Pipe pipe;
  auto logger = logger_on(pipe.writer());
  for (std::size_t i = 0; i < logged; ++i) logger->info("line {}", i);  // no program reads
  std::string text;
  while (lines_accounted_for(text) < logged) text += pipe.read_up_to("\n");
  EXPECT_EQ(lines_accounted_for(text), logged);
  EXPECT_NE(text.find(" lines missing in this log: the program that reads the log is too slow\n"),
            std::string::npos);
  logger->info("after");
  EXPECT_EQ(pipe.read_up_to("after\n"), "after\n");
}

TEST(LogSink, EndsIfItsReaderDoesNotRead) {
  const Pipe pipe;
  auto logger = logger_on(pipe.writer());
  for (int i = 0; i < 2000; ++i) logger->info("line {}", i);
  logger->flush();
  logger.reset();
}

TEST(LogSink, EndsIfItsReaderHasClosed) {
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  Pipe pipe;
  auto logger = logger_on(pipe.writer());
  logger->info("read");
  logger->flush();
  pipe.close_reader();
  for (int i = 0; i < 2000; ++i) logger->info("line {}", i);
  logger.reset();
  std::signal(SIGPIPE, before);
}

TEST(WriteWithin, TimesOutOnAFullPipeAndKeepsTheRest) {
  Pipe pipe;
  const std::string text(10'000, 'a');
  std::string_view rest = text;
  EXPECT_EQ(write_within(pipe.writer(), rest, std::chrono::milliseconds(10)), Written::timed_out);
  EXPECT_EQ(rest.size(), text.size() - 4096);
  pipe.close_writer();
  EXPECT_EQ(pipe.read_up_to("b").size(), 4096u);
}

TEST(WriteWithin, FailsOnAReadOnlyFile) {
  std::string_view rest = "text";
  const int read_only = open("/dev/null", O_RDONLY | O_CLOEXEC);
  EXPECT_EQ(write_within(read_only, rest, std::chrono::milliseconds(10)), Written::failed);
  EXPECT_EQ(rest, "text");
  close(read_only);
}

}  // namespace
}  // namespace hystcan::app::log_sink_test
