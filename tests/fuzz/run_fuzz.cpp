// For any bytes as run.json of a run's folder, the run is either refused with the file's name, or read,
// written and read again.
#include <nlohmann/json.hpp>
#include <string>

#include "runs/run.h"
#include "tests/fuzz/refusal.h"

using namespace hystcan;

namespace {

class RunFolder {
 public:
  RunFolder() {
    std::filesystem::create_directory(path_);
    std::ofstream(path_ / "cycles_0001.csv") << "cycle,time_s,axis,state,fault,position_um,error_um\n"
                                                "1,0.001,x,tracking,none,1.5,0.5\n"
                                                "2,0.002,y,faulted,following error,2.5,1.5\n";
  }
  ~RunFolder() { std::filesystem::remove_all(path_); }
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("hystcan_fuzz_run_" + std::to_string(getpid()));
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const RunFolder folder;
  std::ofstream(folder.path() / runs::info_name, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const runs::RunInfo info = runs::read_run_info(folder.path());
    const runs::Run run(folder.path());
    fuzz::demand(run.info().axes.size() >= info.axes.size());
    runs::write_run_info(folder.path(), info);
    fuzz::demand(to_json(runs::read_run_info(folder.path())).dump() == to_json(info).dump());
  } catch (const Error& error) {
    const std::string_view what = error.what();
    fuzz::demand(what.starts_with((folder.path() / runs::info_name).string() + ": "));
    fuzz::demand(what.find("expected ") != std::string_view::npos &&
                 what.find('\n') == std::string_view::npos);
  }
  return 0;
}
