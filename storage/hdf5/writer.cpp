#include <algorithm>
#include <limits>
#include <utility>

#include "storage/hdf5/handle.h"

namespace hystcan::storage {
namespace {

constexpr hsize_t chunk_rows = 65'536;

Handle text_type(const std::filesystem::path& file) {
  Handle type = checked(H5Tcopy(H5T_C_S1), H5Tclose, file, "no text");
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

Handle value_type(const Hdf5Column& column, const std::filesystem::path& file) {
  if (column.words.empty()) return checked(H5Tcopy(H5T_IEEE_F64LE), H5Tclose, file, column.name);
  Handle type = checked(H5Tenum_create(H5T_STD_U8LE), H5Tclose, file, column.name);
  for (std::size_t i = 0; i < column.words.size(); ++i) {
    const auto value = static_cast<std::uint8_t>(i);
    if (H5Tenum_insert(type.get(), column.words[i].c_str(), &value) < 0) refuse(file, column.name);
  }
  return type;
}

/// Datasets are made one after the other; all grow together.
class Table final : public Hdf5Table {
 public:
  Table(std::filesystem::path file, hid_t where, const std::vector<Hdf5Column>& columns,
        Hdf5Writer::Compression compression)
      : file_(std::move(file)) {
    for (const Hdf5Column& column : columns) add(where, column, compression);
  }

  void append(std::span<const std::vector<double>> columns) override {
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

  void add(hid_t where, const Hdf5Column& column, Hdf5Writer::Compression compression) {
    const hsize_t none = 0, no_end = H5S_UNLIMITED, chunk = chunk_rows;
    const Handle space = checked(H5Screate_simple(1, &none, &no_end), H5Sclose, file_, column.name);
    const Handle layout = checked(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, file_, column.name);
    H5Pset_chunk(layout.get(), 1, &chunk);
    H5Pset_fill_time(layout.get(), H5D_FILL_TIME_NEVER);
    if (compression == Hdf5Writer::Compression::deflate) {
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

  std::unique_ptr<Hdf5Table> add_table(const std::string& group, const std::vector<Hdf5Column>& columns,
                                       Compression compression) override {
    const Handle where = group_of(group);
    auto table = std::make_unique<Table>(path_, where.get(), columns, compression);
    for (const Hdf5Column& column : columns)
      if (!column.unit.empty()) set((group == "/" ? "" : group) + "/" + column.name, "unit", column.unit);
    return table;
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
};

}  // namespace

std::unique_ptr<Hdf5Writer> make_writer(const std::filesystem::path& file) {
  return std::make_unique<Writer>(file);
}

}  // namespace hystcan::storage
