// For any bytes as a configuration, with the changes in its last lines, TomlEdit either refuses with a reason
// and changes nothing, or the text contains the value and is still TOML.
#include <sstream>
#include <string>

#include "base/error.h"
#include "config/document/toml_edit.h"
#include "config/document/toml_text.h"
#include "tests/fuzz/demand.h"

using namespace hystcan;

namespace {

/// Returns true if the change was made.
template <class Change>
bool changed_or_refused(config::TomlEdit& edit, Change change) {
  const std::string before = edit.text();
  try {
    change();
    return true;
  } catch (const Error& error) {
    fuzz::demand_advice(error.what());
    fuzz::demand(edit.text() == before);
    return false;
  }
}

/// Commenting out an absent key changes nothing; a key that shares its line with others is refused.
bool is_there(const config::TomlEdit& edit, const std::string& path) {
  config::TomlEdit again(edit.text(), "text");
  return !changed_or_refused(again, [&] { again.comment_out(path); }) || again.text() != edit.text();
}

void obey(config::TomlEdit& edit, const std::string& line) {
  const std::size_t equals = line.find('=');
  const std::string path = line.substr(0, equals);
  if (equals == std::string::npos) {
    if (changed_or_refused(edit, [&] { edit.comment_out(path); })) fuzz::demand(!is_there(edit, path));
  } else if (changed_or_refused(edit, [&] { edit.set(path, line.substr(equals + 1)); })) {
    fuzz::demand(is_there(edit, path));
  }
  static_cast<void>(config::parse_toml(edit.text(), "edited"));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::string_view separator =
      "\n#---\n";  // the text, then a change in each line: KEY=VALUE or KEY
  const std::string all(reinterpret_cast<const char*>(data), size);
  const std::size_t end = all.find(separator);
  try {
    config::TomlEdit edit(all.substr(0, end), "text");
    std::istringstream changes(end == std::string::npos ? "" : all.substr(end + separator.size()));
    std::string line;
    for (int i = 0; i < 8 && std::getline(changes, line); ++i) obey(edit, line);
  } catch (const Error&) {  // the text is no TOML
  }
  return 0;
}
