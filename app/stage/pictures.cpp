#include "app/stage/pictures.h"

#include <system_error>

#include "base/output_file.h"
#include "base/python_module.h"

namespace hystcan::app {

const std::vector<std::string>& picture_formats() {
  static const std::vector<std::string> formats{"svg", "png", "pdf"};
  return formats;
}

std::optional<std::string> draw_pictures(const std::filesystem::path& list,
                                         const std::vector<Picture>& pictures) {
  nlohmann::json all = nlohmann::json::array();
  for (const Picture& picture : pictures) {
    nlohmann::json one{{"kind", picture.kind},
                       {"data", picture.data},
                       {"to", picture.to},
                       {"size_mm", {picture.size.width_mm, picture.size.height_mm}}};
    if (!picture.facts.empty()) one.update(picture.facts);
    all.push_back(std::move(one));
    std::error_code ignored;
    for (const std::string& name : picture.to) std::filesystem::remove(list.parent_path() / name, ignored);
  }
  write_file(list, all.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
  return PythonModule("plot", {list.string()}, "python3-matplotlib").finish();
}

std::string file_name_of(std::string_view text) {
  std::string name(text);
  for (char& c : name) {
    const bool is_letter_or_digit =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!is_letter_or_digit && std::string_view("._-+").find(c) == std::string_view::npos) c = '_';
  }
  if (name.empty() || name.front() == '.' || name.front() == '-') name.insert(0, "_");
  constexpr std::size_t longest = 100;
  return name.substr(0, longest);
}

}  // namespace hystcan::app
