# Debian 12 packages; scripts/packages names them. Third-party headers are included as SYSTEM: their warnings are not
# ours.
find_package(Threads REQUIRED)
# Eigen 3.4 and Eigen 5 each refuse a version range that contains both.
find_package(Eigen3 REQUIRED NO_MODULE)
if(Eigen3_VERSION VERSION_LESS 3.4)
  message(FATAL_ERROR "Eigen ${Eigen3_VERSION} is too old: hystcan needs 3.4")
endif()
find_package(Boost 1.74 REQUIRED CONFIG)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
