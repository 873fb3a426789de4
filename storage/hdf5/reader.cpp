#include <utility>

#include "storage/hdf5/handle.h"

namespace hystcan::storage {
namespace {

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

}  // namespace

std::unique_ptr<Hdf5Reader> make_reader(const std::filesystem::path& file) {
  return std::make_unique<Reader>(file);
}

}  // namespace hystcan::storage
