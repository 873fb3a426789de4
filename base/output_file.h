// An output file that is complete or absent.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>

namespace hystcan {

/// The text goes to a temporary file in the same folder; commit() moves it to the path. Without commit() the
/// temporary file is removed. The permissions of a file that is replaced stay; one that no user may write is
/// not replaced. A link is followed. If the path is a device or a pipe, the text goes there
/// directly. Throws RunError if the file cannot be written, Error if the path is empty.
class OutputFile {
 public:
  /// `durable`: commit() returns when the file is on the disk, so that it is complete or absent also after a
  /// loss of power. A link is not followed but replaced, so that no file of another user is written.
  enum class Kind : std::uint8_t { plain, durable };

  explicit OutputFile(const std::filesystem::path& path, Kind kind = Kind::plain);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void commit();

  /// The temporary file, for a library that writes to a file by its name. Throws Error for a device or a
  /// pipe.
  const std::filesystem::path& written() const;

 private:
  void open_beside();
  [[noreturn]] void fail(int error) const;

  void move_to_the_path();

  Kind kind_;
  std::filesystem::path path_;
  std::filesystem::path written_;  ///< temporary file; empty if path_ is written directly, or after commit()
  std::FILE* file_ = nullptr;
};

/// A file with this text, complete or absent.
void write_file(const std::filesystem::path& path, std::string_view text);

/// Throws as create_folder() would, and creates nothing: before work that may fail.
void refuse_as_folder(const std::filesystem::path& folder);
/// Creates the folder and those above it. Throws Error if the name is empty or there is a file of this name,
/// RunError if it cannot be created.
void create_folder(const std::filesystem::path& folder);

/// Throws Error if the output file is an input file too: it would be lost while it is read.
void refuse_to_overwrite(const std::filesystem::path& output, const std::filesystem::path& input);

/// The same where the input may be a folder, also if the output is one of its files.
void refuse_to_overwrite_any_of(const std::filesystem::path& output, const std::filesystem::path& input);

/// Throws Error if there is a file of this name, unless it may be overwritten. A device or a pipe is none.
void refuse_to_replace(const std::filesystem::path& output, bool may_overwrite);

/// Throws Error if two outputs are the same file.
void refuse_to_share(const std::filesystem::path& one, const std::filesystem::path& other);

}  // namespace hystcan
