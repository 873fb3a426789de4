// What is in force but not in the configuration file, as an edit of the file that keeps its comments; and the
// way back: the file as it was before the last save is kept beside it as FILE.before-save. Undoing the save
// exchanges the two files, so that a second undo brings the saved file back.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/schema/settings.h"

namespace hystcan::app {

struct ConfigSave {
  std::string before;   ///< the text of the file as it is
  std::string text;     ///< of the file with the edit
  std::string diff;     ///< lines, with `- ` and `+ ` before those that change; empty if none does
  std::string digest;   ///< of the file as it is and of the edit
  bool undoes = false;  ///< it brings back what is kept
};

/// From the text of a file as it is to another one.
ConfigSave config_save(const std::string& before, const std::string& text);
/// `unsaved`: from the file to what is in force. Throws Error where the file has no place for a key, or
/// could not be read with them.
ConfigSave save_of(const std::filesystem::path& file, const std::vector<config::Change>& unsaved);

/// FILE.before-save beside the file; a link is followed.
std::filesystem::path kept_beside(const std::filesystem::path& file);

/// The file as it was before the last save. Throws Error if there is none, or if it is no longer valid. The
/// present file need not be valid.
ConfigSave undo_of(const std::filesystem::path& file);

/// Replaces the file and keeps its former text. Throws RunError if that cannot be kept; nothing is saved
/// then.
void write_save(const std::filesystem::path& file, const ConfigSave& save);

/// Lines of both texts, with two lines of context around each change.
std::string line_diff(const std::string& before, const std::string& after);

}  // namespace hystcan::app
