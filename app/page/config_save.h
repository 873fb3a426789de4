// Saves settings of the running controller that differ from its configuration file. The file is edited, so
// its comments remain. The text before the last save is kept in the same folder as FILE.before-save. An undo
// exchanges the two files; a second undo therefore restores the save.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/schema/settings.h"

namespace hystcan::app {

struct ConfigSave {
  std::string before;   ///< current text of the file
  std::string text;     ///< text of the file after the save
  std::string diff;     ///< difference from `before` to `text`: changed lines have `- ` or `+ `; may be empty
  std::string digest;   ///< hash of both texts, with which the client confirms exactly this save
  bool undoes = false;  ///< true if this is an undo, which restores the kept file
};

/// Returns the description of a change of a file from the text `before` to the text `text`.
ConfigSave config_save(const std::string& before, const std::string& text);
/// Returns the description of a save. `unsaved`: settings in force that differ from the file. Throws Error if
/// a setting cannot be inserted into the file, or if the result would be invalid. Writes nothing.
ConfigSave save_of(const std::filesystem::path& file, const std::vector<config::Change>& unsaved);

/// Returns the path FILE.before-save. If `file` is a symbolic link, the path is in the folder of the target.
std::filesystem::path kept_beside(const std::filesystem::path& file);

/// Returns the description of an undo, which restores the text before the last save. Throws Error if the kept
/// file is missing or no longer valid. The current file may be invalid. Writes nothing.
ConfigSave undo_of(const std::filesystem::path& file);

/// Writes the new text to the file and keeps the previous text. Throws RunError if the previous text cannot
/// be kept. After this error, a save has changed nothing, but an undo has already restored the file.
void write_save(const std::filesystem::path& file, const ConfigSave& save);

/// Returns the changed lines of two texts. Each change has two unchanged lines before and after it.
std::string line_diff(const std::string& before, const std::string& after);

}  // namespace hystcan::app
