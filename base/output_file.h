// An output file that is either complete or absent: an interrupted program leaves no incomplete file.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>

namespace hystcan {

/// Writes the text to a temporary file in the folder of the output file. commit() renames the temporary file
/// to the output file. Without commit(), the destructor removes the temporary file.
///
/// The new file has the permissions of the file that it replaces. A file that nobody may write is not
/// replaced. If the path is a link, the target of the link is replaced. If the path is a device or a pipe,
/// the text is written to it directly. Throws RunError if the file cannot be written, Error if the path is
/// empty.
class OutputFile {
 public:
  /// `durable`: commit() waits until the file is on the disk. Then the file is complete or absent even after
  /// a loss of power. A `durable` file replaces a link itself, not its target, so that a link cannot lead to
  /// another user's file.
  enum class Kind : std::uint8_t { plain, durable };

  explicit OutputFile(const std::filesystem::path& path, Kind kind = Kind::plain);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void commit();

  /// Returns the path of the temporary file, for libraries that open a file by its name. Throws Error if the
  /// output is a device or a pipe.
  const std::filesystem::path& written() const;

 private:
  void open_beside();
  [[noreturn]] void fail(int error) const;

  void move_to_the_path();

  Kind kind_;
  std::filesystem::path path_;
  /// Path of the temporary file. Empty if path_ is written directly, and after commit().
  std::filesystem::path written_;
  std::FILE* file_ = nullptr;
};

/// Writes a file with this text, using OutputFile: the file is complete or absent.
void write_file(const std::filesystem::path& path, std::string_view text);

/// Throws the errors of create_folder(), but does not create the folder. Called before long work, so that the
/// work is not lost.
void refuse_as_folder(const std::filesystem::path& folder);
/// Creates the folder and its parents. Throws Error if the name is empty or belongs to a file. Throws
/// RunError if the folder cannot be created.
void create_folder(const std::filesystem::path& folder);

/// Throws Error if `output` and `input` are the same file, because writing would destroy the input.
void refuse_to_overwrite(const std::filesystem::path& output, const std::filesystem::path& input);

/// Does the check of refuse_to_overwrite() for an input that may be a folder: also throws Error if `output`
/// is one of the files in this folder.
void refuse_to_overwrite_any_of(const std::filesystem::path& output, const std::filesystem::path& input);

/// Throws Error if `output` exists as a regular file and `may_overwrite` is false.
void refuse_to_replace(const std::filesystem::path& output, bool may_overwrite);

/// Throws Error if the two output files of a command are the same file.
void refuse_to_share(const std::filesystem::path& one, const std::filesystem::path& other);

}  // namespace hystcan
