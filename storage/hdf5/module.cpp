// hystcan_hdf5.so: the code that needs libhdf5.
#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "storage/hdf5.h"

namespace hystcan::storage {
namespace {

// ---- Handles and errors of the C library

/// Takes the innermost description: "unable to open file: ... errno = 2, error message = 'No such file or
/// directory'".
herr_t take_description(unsigned, const H5E_error2_t* error, void* into) {
  auto& description = *static_cast<std::string*>(into);
  if (description.empty() && error->desc != nullptr) description = error->desc;
  return 0;
}

/// "No space left on device" out of "file write failed: time = ..., errno = 28, error message = '...', ...".
std::string in_short(const std::string& reason) {
  constexpr std::string_view before = "error message = '";
  const auto at = reason.find(before);
  if (at == std::string::npos) return reason;
  const auto begin = at + before.size();
  return reason.substr(begin, reason.find('\'', begin) - begin);
}

/// The reason that the library gives for its last failure, and an empty stack of errors.
std::string last_reason() {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_description, &reason);
  H5Eclear2(H5E_DEFAULT);
  return reason.empty() ? "the library gives no reason" : in_short(reason);
}

/// Keeps the library from printing its errors, which become exceptions. It remembers that for each thread.
void keep_quiet() {
  thread_local const bool once = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  static_cast<void>(once);
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw Hdf5Error(fmt::format("{}: {}: {}", file.string(), what, last_reason()));
}

/// Closes what it holds.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close how) : id_(id), close_(how) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() { close(); }

  hid_t get() const { return id_; }
  herr_t close() { return id_ >= 0 ? close_(std::exchange(id_, H5I_INVALID_HID)) : 0; }

 private:
  hid_t id_;
  Close close_;
};

/// Throws where the call has failed.
Handle checked(hid_t id, Handle::Close how, const std::filesystem::path& file, const std::string& what) {
  if (id < 0) refuse(file, what);
  return {id, how};
}

// ---- Reading

class Reader final : public Hdf5Reader {
 public:
  explicit Reader(std::filesystem::path file)
      : path_(std::move(file)),
        file_(checked(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, path_,
                      "cannot be read, expected an HDF5 file")) {}

  bool has(const std::string& dataset) const override {
    return H5Lexists(file_.get(), dataset.c_str(), H5P_DEFAULT) > 0;
  }

  std::uint64_t rows(const std::string& dataset) const override {
    const Handle opened = dataset_of(dataset);
    const Handle space = checked(H5Dget_space(opened.get()), H5Sclose, path_, dataset);
    const Handle type = checked(H5Dget_type(opened.get()), H5Tclose, path_, dataset);
    const H5T_class_t kind = H5Tget_class(type.get());
    hsize_t rows = 0;
    if (H5Sget_simple_extent_ndims(space.get()) != 1 || (kind != H5T_FLOAT && kind != H5T_INTEGER))
      throw Hdf5Error(
          fmt::format("{}: {} is no row of numbers, expected a one-dimensional dataset of numbers",
                      path_.string(), dataset));
    H5Sget_simple_extent_dims(space.get(), &rows, nullptr);
    return rows;
  }

  void read(const std::string& dataset, std::uint64_t from, std::span<double> into) const override {
    keep_quiet();
    const Handle opened = dataset_of(dataset);
    const Handle there = checked(H5Dget_space(opened.get()), H5Sclose, path_, dataset);
    const hsize_t first = from, count = into.size();
    const Handle here = checked(H5Screate_simple(1, &count, nullptr), H5Sclose, path_, dataset);
    if (H5Sselect_hyperslab(there.get(), H5S_SELECT_SET, &first, nullptr, &count, nullptr) < 0 ||
        H5Dread(opened.get(), H5T_NATIVE_DOUBLE, here.get(), there.get(), H5P_DEFAULT, into.data()) < 0)
      refuse(path_, dataset + " cannot be read");
  }

  std::optional<std::string> text(const std::string& object, const std::string& name) const override {
    if (H5Aexists_by_name(file_.get(), object.c_str(), name.c_str(), H5P_DEFAULT) <= 0) return std::nullopt;
    const Handle attribute =
        checked(H5Aopen_by_name(file_.get(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                H5Aclose, path_, name);
    const Handle type = checked(H5Aget_type(attribute.get()), H5Tclose, path_, name);
    if (H5Tget_class(type.get()) != H5T_STRING) return std::nullopt;
    return H5Tis_variable_str(type.get()) > 0 ? variable_text(attribute, type) : fixed_text(attribute, type);
  }

 private:
  Handle dataset_of(const std::string& name) const {
    return checked(H5Dopen2(file_.get(), name.c_str(), H5P_DEFAULT), H5Dclose, path_, "no dataset " + name);
  }

  static std::optional<std::string> variable_text(const Handle& attribute, const Handle& type) {
    char* data = nullptr;
    if (H5Aread(attribute.get(), type.get(), &data) < 0 || data == nullptr) return std::nullopt;
    std::string text(data);
    H5free_memory(data);
    return text;
  }
  static std::optional<std::string> fixed_text(const Handle& attribute, const Handle& type) {
    std::string text(H5Tget_size(type.get()), '\0');
    if (H5Aread(attribute.get(), type.get(), text.data()) < 0) return std::nullopt;
    return text.substr(0, text.find('\0'));
  }

  std::filesystem::path path_;
  Handle file_;
};

// ---- Writing

constexpr hsize_t chunk_rows = 65'536;

Handle text_type(const std::filesystem::path& file) {
  Handle type = checked(H5Tcopy(H5T_C_S1), H5Tclose, file, "no text");
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

Handle value_type(const Column& column, const std::filesystem::path& file) {
  if (column.words.empty()) return checked(H5Tcopy(H5T_IEEE_F64LE), H5Tclose, file, column.name);
  Handle type = checked(H5Tenum_create(H5T_STD_U8LE), H5Tclose, file, column.name);
  for (std::size_t i = 0; i < column.words.size(); ++i) {
    const auto value = static_cast<std::uint8_t>(i);
    if (H5Tenum_insert(type.get(), column.words[i].c_str(), &value) < 0) refuse(file, column.name);
  }
  return type;
}

/// Datasets are made one after the other; all grow together.
class Table {
 public:
  Table(std::filesystem::path file, hid_t where, const std::vector<Column>& columns, bool is_deflated)
      : file_(std::move(file)) {
    for (const Column& column : columns) add(where, column, is_deflated);
  }

  /// Throws where the last rows could not be written: H5Fflush() does not say so of a dataset that is closed.
  void close() {
    for (Dataset& dataset : datasets_)
      if (dataset.handle.close() < 0) refuse(file_, "cannot be written");
  }

  void append(std::span<const std::vector<double>> columns) {
    if (columns.empty() || columns.front().empty()) return;
    keep_quiet();
    const hsize_t from = rows_, count = columns.front().size();
    rows_ += count;
    for (std::size_t i = 0; i < datasets_.size(); ++i) append_to(datasets_[i], columns[i], from, count);
  }

 private:
  struct Dataset {
    Handle handle;
    std::vector<std::uint8_t> codes;  ///< room for a block
    bool has_words;
  };

  void add(hid_t where, const Column& column, bool is_deflated) {
    const hsize_t none = 0, no_end = H5S_UNLIMITED, chunk = chunk_rows;
    const Handle space = checked(H5Screate_simple(1, &none, &no_end), H5Sclose, file_, column.name);
    const Handle layout = checked(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, file_, column.name);
    H5Pset_chunk(layout.get(), 1, &chunk);
    H5Pset_fill_time(layout.get(), H5D_FILL_TIME_NEVER);
    if (is_deflated) {
      H5Pset_shuffle(layout.get());
      H5Pset_deflate(layout.get(), 1);
    }
    const Handle type = value_type(column, file_);
    datasets_.push_back({checked(H5Dcreate2(where, column.name.c_str(), type.get(), space.get(), H5P_DEFAULT,
                                            layout.get(), H5P_DEFAULT),
                                 H5Dclose, file_, column.name + " cannot be made"),
                         {},
                         !column.words.empty()});
  }

  void append_to(Dataset& dataset, const std::vector<double>& values, hsize_t from, hsize_t count) const {
    const hsize_t end = from + count;
    if (H5Dset_extent(dataset.handle.get(), &end) < 0) refuse(file_, "cannot be written");
    const Handle there = checked(H5Dget_space(dataset.handle.get()), H5Sclose, file_, "cannot be written");
    H5Sselect_hyperslab(there.get(), H5S_SELECT_SET, &from, nullptr, &count, nullptr);
    const Handle here = checked(H5Screate_simple(1, &count, nullptr), H5Sclose, file_, "cannot be written");
    const void* data = values.data();
    hid_t type = H5T_NATIVE_DOUBLE;
    Handle stored(H5I_INVALID_HID, H5Tclose);
    if (dataset.has_words) {
      dataset.codes.resize(values.size());
      std::ranges::transform(values, dataset.codes.begin(), [](double value) {
        return value >= 0.0 && value <= 255.0 ? static_cast<std::uint8_t>(value) : std::uint8_t{255};
      });
      data = dataset.codes.data();
      stored = checked(H5Dget_type(dataset.handle.get()), H5Tclose, file_, "cannot be written");
      type = stored.get();
    }
    if (H5Dwrite(dataset.handle.get(), type, here.get(), there.get(), H5P_DEFAULT, data) < 0)
      refuse(file_, "cannot be written");
  }

  std::filesystem::path file_;
  std::vector<Dataset> datasets_;
  hsize_t rows_ = 0;
};

class Writer final : public Hdf5Writer {
 public:
  explicit Writer(std::filesystem::path file)
      : path_(std::move(file)),
        file_(checked(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, path_,
                      "cannot be made")) {}

  std::size_t add_table(const std::string& group, const std::vector<Column>& columns,
                        bool is_deflated) override {
    const Handle where = group_of(group);
    tables_.emplace_back(path_, where.get(), columns, is_deflated);
    for (const Column& column : columns)
      if (!column.unit.empty()) set((group == "/" ? "" : group) + "/" + column.name, "unit", column.unit);
    return tables_.size() - 1;
  }
  void append(std::size_t table, std::span<const std::vector<double>> columns) override {
    tables_.at(table).append(columns);
  }

  void set(const std::string& object, const std::string& name, const std::string& text) override {
    const char* const data = text.c_str();
    set(object, name, text_type(path_), &data);
  }
  void set(const std::string& object, const std::string& name, double value) override {
    set(object, name, checked(H5Tcopy(H5T_NATIVE_DOUBLE), H5Tclose, path_, name), &value);
  }

  void add_text(const std::string& path, const std::string& text) override {
    const Handle type = text_type(path_);
    const Handle space = checked(H5Screate(H5S_SCALAR), H5Sclose, path_, path);
    const Handle links = checked(H5Pcreate(H5P_LINK_CREATE), H5Pclose, path_, path);
    H5Pset_create_intermediate_group(links.get(), 1);
    const Handle dataset = checked(
        H5Dcreate2(file_.get(), path.c_str(), type.get(), space.get(), links.get(), H5P_DEFAULT, H5P_DEFAULT),
        H5Dclose, path_, path + " cannot be made");
    const char* const data = text.c_str();
    if (H5Dwrite(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, &data) < 0)
      refuse(path_, path + " cannot be written");
  }

  void close() override {
    keep_quiet();
    for (Table& table : tables_) table.close();
    if (H5Fflush(file_.get(), H5F_SCOPE_LOCAL) < 0 || file_.close() < 0) refuse(path_, "cannot be written");
  }

 private:
  Handle group_of(const std::string& group) const {
    if (group == "/") return checked(H5Gopen2(file_.get(), "/", H5P_DEFAULT), H5Gclose, path_, group);
    return checked(H5Gcreate2(file_.get(), group.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
                   path_, group + " cannot be made");
  }

  void set(const std::string& object, const std::string& name, const Handle& type, const void* data) const {
    const Handle where = checked(H5Oopen(file_.get(), object.c_str(), H5P_DEFAULT), H5Oclose, path_, object);
    const Handle space = checked(H5Screate(H5S_SCALAR), H5Sclose, path_, name);
    const Handle attribute =
        checked(H5Acreate2(where.get(), name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                H5Aclose, path_, name + " cannot be made");
    if (H5Awrite(attribute.get(), type.get(), data) < 0) refuse(path_, name + " cannot be written");
  }

  std::filesystem::path path_;
  Handle file_;
  std::vector<Table> tables_;
};

std::unique_ptr<Hdf5Writer> create(const std::filesystem::path& file) {
  keep_quiet();
  return std::make_unique<Writer>(file);
}
std::unique_ptr<Hdf5Reader> open(const std::filesystem::path& file) {
  keep_quiet();
  return std::make_unique<Reader>(file);
}

}  // namespace
}  // namespace hystcan::storage

extern "C" __attribute__((visibility("default"))) const hystcan::storage::Hdf5Library* hystcan_hdf5() {
  H5dont_atexit();  // its end would write once more what a full disk has refused, and crash
  static const hystcan::storage::Hdf5Library library{&hystcan::storage::create, &hystcan::storage::open};
  return &library;
}
