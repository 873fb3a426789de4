// Saves the settings in force that differ from the configuration file, as an edit of the file that keeps its
// comments. The file before the last save is kept in the same folder as FILE.before-save. Undoing the save
// exchanges the two files, so that a second undo restores the saved file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/schema/settings.h"

namespace hystcan::app {

struct ConfigSave {
  std::string before;   ///< the present text of the file
  std::string text;     ///< the text after the edit
  std::string diff;     ///< lines, with `- ` and `+ ` before changed lines; empty if there is no change
  std::string digest;   ///< digest of the present file and of the edit
  bool undoes = false;  ///< true if it restores the kept file
};

/// Describes the change from the present text of a file to another text.
ConfigSave config_save(const std::string& before, const std::string& text);
/// Describes saving `unsaved`, the changes from the file to the settings in force. Throws Error if the file
/// has no place for a key, or if the result would not be valid.
ConfigSave save_of(const std::filesystem::path& file, const std::vector<config::Change>& unsaved);

/// Returns FILE.before-save in the folder of the file; follows a link.
std::filesystem::path kept_beside(const std::filesystem::path& file);

/// Describes the return to the file before the last save. Throws Error if that file is missing or no longer
/// valid. The present file need not be valid.
ConfigSave undo_of(const std::filesystem::path& file);

/// Replaces the file and keeps its previous text. Throws RunError if the previous text can't be kept; nothing
/// is then saved.
void write_save(const std::filesystem::path& file, const ConfigSave& save);

/// Returns the lines of both texts, with two lines of context around each change.
std::string line_diff(const std::string& before, const std::string& after);

}  // namespace hystcan::app
