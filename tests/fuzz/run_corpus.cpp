// Runs a fuzz target without a fuzzer on the given files and directories; fails if there are none.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

int run(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  // The beginnings of the file are inputs, too: they end where a file should not.
  for (std::size_t size = 0; size <= text.size(); size += 1 + size / 64) {
    const std::string input = text.substr(0, size);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  }
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  return 1;
}

int run_all(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return run(path);
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path)) files += run_all(entry.path());
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  int files = 0;
  for (int i = 1; i < argc; ++i) files += run_all(argv[i]);
  std::printf("%d files\n", files);
  return files > 0 ? 0 : 1;
}
