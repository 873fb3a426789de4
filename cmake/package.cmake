# find_package(hystcan) for other projects: hystcan::model and hystcan::identification, with their headers.
include(CMakePackageConfigHelpers)

foreach(room IN ITEMS model identification flags)
  set_target_properties(hystcan_${room} PROPERTIES EXPORT_NAME ${room})
endforeach()
# The headers include each other as "model/...".
target_include_directories(hystcan_flags INTERFACE
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/hystcan>)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/hystcan)
install(TARGETS hystcan_model hystcan_identification hystcan_flags EXPORT hystcan
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT hystcan NAMESPACE hystcan:: FILE hystcan-targets.cmake DESTINATION ${package_folder})
install(DIRECTORY base model identification DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/hystcan FILES_MATCHING PATTERN *.h)
configure_package_config_file(cmake/hystcan-config.cmake.in hystcan-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(hystcan-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/hystcan-config.cmake ${PROJECT_BINARY_DIR}/hystcan-config-version.cmake
  DESTINATION ${package_folder})
