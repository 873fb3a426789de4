// An output file that is either complete or absent.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>

namespace hystcan {

/// Writes the text to a temporary file in the same folder; commit() moves it to the path. Without commit()
/// the temporary file is removed. A replaced file keeps its permissions; a file that no user may write is not
/// replaced. A link is followed. If the path is a device or a pipe, the text is written to it directly.
/// Throws RunError if the file cannot be written, Error if the path is empty.
class OutputFile {
 public:
  /// `durable`: commit() returns when the file is on the disk, so that it is complete or absent after a loss
  /// of power too. A link is replaced, not followed, so that another user's file is never written.
  enum class Kind : std::uint8_t { plain, durable };

  explicit OutputFile(const std::filesystem::path& path, Kind kind = Kind::plain);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void commit();

  /// Returns the path of the temporary file, for a library that writes to a file by its name. Throws Error
  /// for a device or a pipe.
  const std::filesystem::path& written() const;

 private:
  void open_beside();
  [[noreturn]] void fail(int error) const;

  void move_to_the_path();

  Kind kind_;
  std::filesystem::path path_;
  /// Temporary file; empty if path_ is written directly, and after commit().
  std::filesystem::path written_;
  std::FILE* file_ = nullptr;
};

/// Writes a file with this text, complete or absent.
void write_file(const std::filesystem::path& path, std::string_view text);

/// Throws the same errors as create_folder(), but creates nothing. For a check before long work.
void refuse_as_folder(const std::filesystem::path& folder);
/// Creates the folder and its parents. Throws Error if the name is empty or if a file has this name, RunError
/// if the folder cannot be created.
void create_folder(const std::filesystem::path& folder);

/// Throws Error if the output file is also an input file: it would be lost while it is read.
void refuse_to_overwrite(const std::filesystem::path& output, const std::filesystem::path& input);

/// Makes the same check for an input that may be a folder: also throws if the output is one of its files.
void refuse_to_overwrite_any_of(const std::filesystem::path& output, const std::filesystem::path& input);

/// Throws Error if a regular file of this name exists, unless it may be overwritten.
void refuse_to_replace(const std::filesystem::path& output, bool may_overwrite);

/// Throws Error if two outputs are the same file.
void refuse_to_share(const std::filesystem::path& one, const std::filesystem::path& other);

}  // namespace hystcan
