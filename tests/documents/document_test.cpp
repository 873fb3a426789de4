// Every document: its shell blocks parse, its command lines are accepted, and its tables match the program or
// the script; scripts/site checks the links. If HYSTCAN_WRITE_TABLES=1 is in the environment, the test writes
// these tables.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <CLI/CLI.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/answer_json.h"
#include "app/live/control_protocol.h"
#include "app/live/samples.h"
#include "tests/support/process.h"

namespace hystcan::documents::document_test {
namespace {

namespace fs = std::filesystem;

const fs::path source = HYSTCAN_SOURCE_DIR;

struct Block {
  int line;  ///< line of the opening fence
  std::string language, text;
};

struct Document {
  std::string name;   ///< path below the source folder
  std::string prose;  ///< text without blocks; every line keeps its place
  std::vector<Block> blocks;
};

Document read(const fs::path& file) {
  Document document{.name = fs::relative(file, source).string(), .prose = {}, .blocks = {}};
  std::istringstream text(support::read_file(file));
  bool inside = false;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number, document.prose += '\n') {
    const auto begin = line.find_first_not_of(' ');
    if (begin != std::string::npos && line.compare(begin, 3, "```") == 0) {
      inside = !inside;
      if (inside) document.blocks.push_back({number, line.substr(begin + 3), {}});
    } else if (inside) {
      document.blocks.back().text += line + "\n";
    } else {
      document.prose += line;
    }
  }
  return document;
}

const std::map<std::string, Document>& documents() {
  static const std::map<std::string, Document> all = [] {
    std::map<std::string, Document> found;
    const auto add = [&](const fs::path& file) {
      if (file.extension() != ".md") return;
      Document document = read(file);
      found.emplace(document.name, std::move(document));
    };
    for (const auto& entry : fs::directory_iterator(source)) add(entry.path());
    for (const auto& entry : fs::recursive_directory_iterator(source / "docs")) add(entry.path());
    return found;
  }();
  return all;
}

int line_of(const std::string& text, std::ptrdiff_t at) {
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + at, '\n'));
}

/// Returns the simple commands of a shell script, as lists of words. Expansions stay as written; redirections
/// are removed.
std::vector<std::vector<std::string>> commands_of(const std::string& script) {
  std::vector<std::vector<std::string>> commands(1);
  std::string word;
  bool has_word = false;
  bool redirected = false;
  const auto end_word = [&] {
    if (has_word && !redirected) commands.back().push_back(word);
    if (has_word) redirected = false;
    word.clear();
    has_word = false;
  };
  for (std::size_t i = 0; i < script.size(); ++i) {
    const char c = script[i];
    if (c == '\\' && i + 1 < script.size()) {
      if (script[++i] == '\n') continue;
      word += script[i];
      has_word = true;
    } else if (c == '\'' || c == '"') {
      const std::size_t end = std::min(script.find(c, i + 1), script.size());
      word += script.substr(i + 1, end - i - 1);
      has_word = true;
      i = end;
    } else if (c == '#' && !has_word) {
      i = std::min(script.find('\n', i), script.size()) - 1;
    } else if (std::string_view("\n;|&()").find(c) != std::string_view::npos) {
      end_word();
      if (!commands.back().empty()) commands.emplace_back();
    } else if (c == '>' || c == '<') {
      end_word();
      redirected = true;
    } else if (c == ' ') {
      end_word();
    } else {
      word += c;
      has_word = true;
    }
  }
  end_word();
  return commands;
}

/// Returns the words after the program's name, also after `sudo`, `taskset` or a variable; empty if it is
/// another command. A shell variable counts as a number.
std::vector<std::string> arguments_of_hystcan(const std::vector<std::string>& command) {
  static const std::set<std::string> others{"cp", "ln", "ls", "install", "cmake", "setcap", "ldd", "apt-get"};
  if (command.empty() || others.contains(command.front())) return {};
  for (auto word = command.begin(); word != command.end(); ++word)
    if (*word == "hystcan" || (word->ends_with("/hystcan") && word->find('=') == std::string::npos)) {
      std::vector<std::string> arguments(word + 1, command.end());
      for (std::string& argument : arguments)
        if (argument.starts_with('$')) argument = "1";
      return arguments;
    }
  return {};
}

/// Parses the program's command line and ends before the command runs.
class CommandLine {
 public:
  CommandLine() {
    cli_.name("hystcan");
    cli_.set_version_flag("--version", "");
    cli_.require_subcommand(1);
    app::add_commands(cli_, status_);
    cli_.parse_complete_callback([] { throw CLI::Success(); });  // before the command runs
  }

  const CLI::App& tree() const { return cli_; }

  /// Returns the problem, or an empty text. An excerpt may omit required options.
  std::string refusal(std::vector<std::string> arguments, bool is_excerpt) {
    std::ranges::reverse(arguments);
    try {
      cli_.parse(std::move(arguments));
    } catch (const CLI::Success&) {  // includes --help and --version
    } catch (const CLI::ParseError& error) {
      const bool is_unknown = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError);
      if (!is_excerpt || is_unknown) return error.what();
    }
    return {};
  }

 private:
  int status_ = 0;
  CLI::App cli_;
};

/// Returns the shell blocks, and the lines after a prompt in blocks that show output.
std::vector<Block> scripts_of(const Document& document) {
  std::vector<Block> scripts;
  for (const Block& block : document.blocks) {
    if (block.language == "sh") scripts.push_back(block);
    std::istringstream lines(block.text);
    std::string line;
    for (int number = block.line + 1; std::getline(lines, line); ++number)
      if (line.starts_with("$ ")) scripts.push_back({number, "sh", line.substr(2)});
  }
  return scripts;
}

TEST(Documents, HaveShellBlocksThatParse) {
  const support::ScratchFolder folder;
  for (const auto& [name, document] : documents()) {
    for (const Block& script : scripts_of(document)) {
      std::ofstream(folder / "script") << script.text;
      support::Process bash({"bash", "-n", (folder / "script").string()});
      EXPECT_EQ(bash.wait(), 0) << name << ':' << script.line << ": " << bash.err();
    }
  }
}

// A formatter that treats a block as prose leaves its fence in the middle of a line.
TEST(Documents, HaveFencesOnlyAtTheStartOfALine) {
  for (const auto& [name, document] : documents())
    if (const auto at = document.prose.find("```"); at != std::string::npos)
      ADD_FAILURE() << name << ':' << line_of(document.prose, static_cast<std::ptrdiff_t>(at));
}

TEST(Documents, HaveCommandLinesThatTheProgramAccepts) {
  std::size_t count = 0;
  for (const auto& [name, document] : documents()) {
    for (const Block& script : scripts_of(document)) {
      for (const auto& command : commands_of(script.text)) {
        const std::vector<std::string> arguments = arguments_of_hystcan(command);
        if (arguments.empty()) continue;
        ++count;
        EXPECT_EQ(CommandLine().refusal(arguments, false), "")
            << name << ':' << script.line << ": hystcan " << fmt::format("{}", fmt::join(arguments, " "));
      }
    }
  }
  EXPECT_GT(count, 50u);
}

TEST(Documents, NameInTheirTextOnlyCommandsAndOptionsThatExist) {
  const std::regex span("`hystcan ([a-z][^`]*)`");
  std::size_t count = 0;
  for (const auto& [name, document] : documents()) {
    const std::string& prose = document.prose;
    for (std::sregex_iterator it(prose.begin(), prose.end(), span), end; it != end; ++it) {
      const auto commands = commands_of(std::regex_replace(it->str(1), std::regex("\n"), " "));
      if (commands.front().empty()) continue;
      ++count;
      EXPECT_EQ(CommandLine().refusal(commands.front(), true), "")
          << name << ':' << line_of(prose, it->position()) << ": " << it->str();
    }
  }
  EXPECT_GT(count, 50u);
}

std::string row(const std::string& what, const std::string& meaning) {
  return fmt::format("| `{}` | {} |\n", what, std::regex_replace(meaning, std::regex("\\|"), "\\|"));
}

/// Returns the options of a command, then its subcommands and their options.
std::string rows_of(const CLI::App& command, const std::string& before) {
  std::string rows;
  for (const CLI::Option* option :
       command.get_options([](const CLI::Option* o) { return o->nonpositional(); })) {
    if (option->check_name("--help")) continue;
    std::string what = before + option->get_name();
    if (option->get_expected_max() > 0)
      what += " " + option->get_type_name().substr(option->get_type_name().find(':') + 1);
    std::string meaning = option->get_description();
    for (const CLI::Option* needed : option->get_needs()) meaning += "; with " + needed->get_name();
    if (!option->get_default_str().empty())
      meaning += fmt::format(" (default {})", option->get_default_str());
    rows += row(what, meaning);
  }
  for (const CLI::App* below : command.get_subcommands({})) {
    std::string words = before + below->get_name();
    for (const CLI::Option* option :
         below->get_options([](const CLI::Option* o) { return o->get_positional(); }))
      words += " " + option->get_name(true);
    rows += row(words, below->get_description());
    rows += rows_of(*below, before + below->get_name() + " ");
  }
  return rows;
}

TEST(ProtocolDocument, HasTheTableOfCrcDistance) {
  support::Process script({(source / "tests/documents/crc_distance").string()});
  ASSERT_EQ(script.wait(), 0) << script.err();
  EXPECT_NE(support::read_file(source / "docs/protocol/frames.md").find("\n\n" + script.out() + "\n"),
            std::string::npos)
      << script.out();
}

TEST(CommandsDocuments, HaveTheTablesOfTheProgram) {
  constexpr std::string_view head = "<!-- options: ";
  constexpr std::string_view tail = "<!-- end -->";
  const CommandLine commands;
  std::set<std::string> described;
  for (const auto& page : fs::directory_iterator(source / "docs/commands")) {
    const std::string text = support::read_file(page.path());
    std::string written;
    std::size_t rest = 0;
    for (std::size_t at = text.find(head); at != std::string::npos; at = text.find(head, rest)) {
      const std::size_t begin = at + head.size();
      const std::string name = text.substr(begin, text.find(' ', begin) - begin);
      const std::size_t end = text.find(tail, at);
      const std::string table = fmt::format("{}{} -->\n| option | meaning |\n|---|---|\n{}", head, name,
                                            rows_of(*commands.tree().get_subcommand(name), ""));
      EXPECT_EQ(text.substr(at, end - at), table) << "HYSTCAN_WRITE_TABLES=1 writes the tables";
      described.insert(name);
      written += text.substr(rest, at - rest) + table;
      rest = end;
    }
    written += text.substr(rest);
    if (std::getenv("HYSTCAN_WRITE_TABLES") != nullptr) std::ofstream(page.path()) << written;
  }
  for (const CLI::App* command : commands.tree().get_subcommands({}))
    EXPECT_TRUE(rows_of(*command, "").empty() || described.contains(command->get_name()))
        << command->get_name();
}

/// Expects this part between the two texts of the document, or writes it if the environment requests this.
void expect_part(const fs::path& file, const std::string& head, const std::string& tail,
                 const std::string& part) {
  std::string text = support::read_file(file);
  ASSERT_NE(text.find(head), std::string::npos);
  const std::size_t begin = text.find(head) + head.size();
  const std::size_t length = text.find(tail, begin) - begin;
  EXPECT_EQ(text.substr(begin, length), part) << "HYSTCAN_WRITE_TABLES=1 writes it";
  if (std::getenv("HYSTCAN_WRITE_TABLES") != nullptr)
    std::ofstream(file) << text.replace(begin, length, part);
}

TEST(LatencyDocument, HasTheRatesOfTheProgram) {
  support::Process program({HYSTCAN_PROGRAM, "check", "--rates"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  expect_part(source / "docs/latency.md", "$ hystcan check --rates\n", "```", program.out());
}

TEST(ControlSocketDocument, HasTheTableOfTheCommands) {
  std::string table = "| `do` | arguments | it | controller | twin |\n|---|---|---|---|---|\n";
  for (const app::ControlCommand& row : app::protocol::commands) {
    std::vector<std::string> arguments;
    for (const auto& [name, ctl, type, example, meaning, is_needed] : row.arguments)
      arguments.push_back(is_needed ? fmt::format("`{}`", name) : fmt::format("[`{}`]", name));
    table += fmt::format("| `{}` | {} | {} | {} | {} |\n", row.word, fmt::join(arguments, ", "),
                         word_of(row.access), word_of(row.controller), word_of(row.twin));
  }
  expect_part(source / "docs/control_socket.md", "<!-- commands -->\n", "<!-- end -->", table);
}

/// The members of an answer, and of each struct within it.
class AnswerMembers {
 public:
  struct Row {
    std::string path;  ///< prefix of the struct within the answer: `axes[]`
    std::vector<std::string> members{};
  };

  template <class Answer>
  explicit AnswerMembers(Answer answer) {
    look_into(answer, "");
  }

  template <class T>
  void member(const char* name, T& value, app::About about) {
    const bool has_unit_in_name = std::string_view(name).ends_with(about.unit);
    rows[row_].members.push_back(
        fmt::format("`{}`{}: {}", name, has_unit_in_name ? std::string() : fmt::format(" ({})", about.unit),
                    about.meaning));
    names.insert(name);
    const std::string& path = rows[row_].path;
    look_into(value, path.empty() ? name : fmt::format("{}.{}", path, name));
  }
  template <class T>
  void optional(const char* name, T& value, bool, app::About about) {
    member(name, value, about);
  }

  std::vector<Row> rows;
  std::set<std::string> names;

 private:
  template <class T>
  void look_into(T& value, const std::string& path) {
    using app::visit;
    if constexpr (app::is_list<T> || app::is_optional<T>) {
      typename T::value_type element{};
      look_into(element, app::is_list<T> ? path + "[]" : path);
    } else if constexpr (!app::is_value<T>) {
      const std::size_t before = std::exchange(row_, rows.size());
      rows.push_back({path});
      visit(*this, value);
      row_ = before;
    }
  }

  std::size_t row_ = 0;
};

TEST(ControlSocketDocument, HasTheTableOfTheAnswers) {
  std::string table = "| answer | members |\n|---|---|\n";
  const auto add = [&](std::string_view name, const AnswerMembers& answer) {
    for (const auto& [path, members] : answer.rows)
      table += fmt::format("| {}{} | {} |\n", name, path.empty() ? path : fmt::format(": `{}`", path),
                           fmt::join(members, "<br>"));
  };
  for (const app::Reply reply : every<app::Reply>())
    app::with_answer(reply, [&](auto answer) { add(word_of(reply), AnswerMembers(answer)); });
  add("refusal", AnswerMembers(app::RefusedAnswer{}));
  add("greeting of the stream", AnswerMembers(app::StreamGreeting{}));
  expect_part(source / "docs/control_socket.md", "<!-- answers -->\n", "<!-- end -->", table);
}

/// Returns the first groups of all matches.
std::set<std::string> matches(const fs::path& file, const char* pattern) {
  const std::string text = support::read_file(file);
  const std::regex form(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), form), end; it != end; ++it)
    found.insert(it->str(1));
  return found;
}

TEST(Clients, SendOnlyCommandsOfTheTable) {
  std::set<std::string> words, of_page;
  for (const app::ControlCommand& row : app::protocol::commands) {
    words.emplace(row.word);
    if (row.page_place > 0) of_page.emplace(row.word);
  }
  const fs::path protocol = source / "docs/page_protocol.md";
  const auto listed = matches(protocol, "command of the control socket: ([^;]*);");
  ASSERT_EQ(listed.size(), 1U);
  for (const std::string& word : of_page)
    EXPECT_NE(listed.begin()->find('`' + word + '`'), std::string::npos);
  const auto sent = matches(source / "python/hystcan/client.py", R"re(self\.command\("(\w+)")re");
  EXPECT_GT(sent.size(), 10U);
  EXPECT_TRUE(std::ranges::includes(words, sent)) << fmt::format("{}", fmt::join(sent, " "));
  of_page.merge(matches(protocol, "\n\\| `(\\w+)` \\|"));
  for (const auto& script : fs::directory_iterator(source / "app/page/web"))
    for (const std::string& word : matches(script.path(), "\\bdo: '(\\w+)'"))
      EXPECT_TRUE(of_page.contains(word)) << script.path() << ": " << word;
}

TEST(Clients, ReadOnlyMembersOfTheAnswers) {
  std::set<std::string> known{"ok"};
  for (const app::Reply reply : every<app::Reply>())
    app::with_answer(reply, [&](auto answer) { known.merge(AnswerMembers(answer).names); });
  known.merge(AnswerMembers(app::RefusedAnswer{}).names);
  known.merge(AnswerMembers(app::StreamGreeting{}).names);
  const fs::path web = source / "app/page/web";
  auto read = matches(source / "python/hystcan/client.py", R"re(\["(\w+)"\])re");
  read.merge(matches(web / "steering.js", R"(\banswer\.answer\?\.(\w+))"));
  read.merge(matches(web / "status_view.js", R"(\b(?:controller|recording|axis)\??\.(\w+))"));
  EXPECT_GT(read.size(), 15U);
  EXPECT_TRUE(std::ranges::includes(known, read)) << fmt::format("{}", fmt::join(read, " "));
  // The words with an underscore in the view are members of the status, or added by the page's server.
  known.merge(matches(source / "docs/page_protocol.md", "`(\\w+)`"));
  known.insert("peak_um");  // from the shown time
  const auto words = matches(web / "status_view.js", "\\b([a-z]+(?:_[a-z]+)+)\\b");
  EXPECT_TRUE(std::ranges::includes(known, words)) << fmt::format("{}", fmt::join(words, " "));
}

}  // namespace
}  // namespace hystcan::documents::document_test
