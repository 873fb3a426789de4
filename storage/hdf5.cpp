#include "storage/hdf5.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

namespace hystcan::storage {

using nlohmann::json;

Hdf5Writer::Hdf5Writer(std::filesystem::path file)
    : path_(std::move(file)), python_("hdf5", {"write", path_.string()}, hdf5_package) {}

std::size_t Hdf5Writer::add_table(const std::string& group, const std::vector<Column>& columns,
                                  bool is_deflated) {
  json described = json::array();
  for (const Column& column : columns) described.push_back({column.name, column.unit, column.words});
  send({"table", group, std::move(described), is_deflated});
  return tables_++;
}

void Hdf5Writer::append(std::size_t table, std::span<const std::vector<double>> columns) {
  if (columns.front().empty()) return;
  send({"rows", table, columns.front().size()});
  for (const std::vector<double>& column : columns)
    send_bytes({reinterpret_cast<const char*>(column.data()), column.size() * sizeof(double)});
}

void Hdf5Writer::set(const std::string& object, const std::string& name, const std::string& text) {
  send({"set", object, name, text});
}
void Hdf5Writer::set(const std::string& object, const std::string& name, double value) {
  send({"set", object, name, value});
}

void Hdf5Writer::add_text(const std::string& path, const std::string& text) {
  send({"text", path, text.size()});
  send_bytes(text);
}

void Hdf5Writer::close() {
  send(json::array({"end"}));
  if (const auto failure = python_.finish()) throw Hdf5Error(path_, *failure);
}

void Hdf5Writer::send(const json& message) {
  send_bytes(message.dump(-1, ' ', false, json::error_handler_t::replace) + '\n');
}

void Hdf5Writer::send_bytes(std::string_view bytes) {
  if (python_.write(bytes)) return;
  throw Hdf5Error(path_, python_.finish().value_or("Python has ended"));
}

}  // namespace hystcan::storage
