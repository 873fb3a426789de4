# The library hystcan_page_assets: the files of app/page/web, and uPlot from npm, as constants of the program.
set(HYSTCAN_PAGE AUTO CACHE STRING "Build the operator's page: ON needs npm, AUTO leaves the page out without npm, OFF")
set_property(CACHE HYSTCAN_PAGE PROPERTY STRINGS AUTO ON OFF)
set(HYSTCAN_PAGE_MODULES "" CACHE PATH "A folder node_modules that has uPlot: npm is not asked for it")
if(HYSTCAN_PAGE)  # also for AUTO
  find_program(NPM npm)
endif()
if(HYSTCAN_PAGE AND NOT HYSTCAN_PAGE STREQUAL AUTO AND NOT NPM AND NOT HYSTCAN_PAGE_MODULES)
  message(FATAL_ERROR "HYSTCAN_PAGE is ${HYSTCAN_PAGE} and npm is missing: scripts/packages test installs it")
endif()

set(page_web ${PROJECT_SOURCE_DIR}/app/page/web)
set(page_npm ${PROJECT_BINARY_DIR}/page)  # contains node_modules
set(page_list "")                         # "PATH|FILE": a browser requests PATH
set(uplot "")
set(page_missing "")

if(HYSTCAN_PAGE AND HYSTCAN_PAGE_MODULES)
  set(uplot ${HYSTCAN_PAGE_MODULES}/uplot)
elseif(HYSTCAN_PAGE AND NPM)
  set(page_npm_ci ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --fetch-retries=1
    --fetch-retry-mintimeout=2000)
  if(NOT HYSTCAN_TESTS OR HYSTCAN_SANITIZE)
    list(APPEND page_npm_ci --omit=dev)  # omits packages of the browser tests
  endif()
  # At configure time: without a network, AUTO leaves the page out.
  file(MAKE_DIRECTORY ${page_npm})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${page_web}/package-lock.json)
  file(READ ${page_web}/package-lock.json page_lock)
  set(page_npm_stamp "${page_npm_ci}\n${page_lock}")
  set(page_npm_installed "")
  if(EXISTS ${page_npm}/installed)
    file(READ ${page_npm}/installed page_npm_installed)
  endif()
  if(NOT page_npm_installed STREQUAL page_npm_stamp)
    message(STATUS "Installing the page's npm packages")
    file(COPY ${page_web}/package.json ${page_web}/package-lock.json DESTINATION ${page_npm})
    execute_process(COMMAND ${page_npm_ci} WORKING_DIRECTORY ${page_npm} RESULT_VARIABLE page_npm_result)
    if(page_npm_result EQUAL 0)
      file(WRITE ${page_npm}/installed "${page_npm_stamp}")
    else()
      file(REMOVE ${page_npm}/installed)
      set(page_missing "npm could not install uPlot (no network?); the program has no operator's page")
    endif()
  endif()
  if(NOT page_missing)
    set(uplot ${page_npm}/node_modules/uplot)
  elseif(NOT HYSTCAN_PAGE STREQUAL AUTO)
    message(FATAL_ERROR "HYSTCAN_PAGE is ${HYSTCAN_PAGE}, and ${page_missing}")
  endif()
elseif(HYSTCAN_PAGE)
  set(page_missing "npm is missing; the program has no operator's page")
endif()
set(HYSTCAN_PAGE_MISSING "${page_missing}" CACHE INTERNAL "Why the page is left out")
if(uplot)
  install(FILES ${uplot}/LICENSE DESTINATION share/doc/hystcan RENAME uPlot.LICENSE.txt)

  file(GLOB page_sources CONFIGURE_DEPENDS RELATIVE ${page_web} ${page_web}/*.html ${page_web}/*.css ${page_web}/*.js)
  foreach(name IN LISTS page_sources)
    list(APPEND page_list "/${name}|${page_web}/${name}")
  endforeach()
  list(APPEND page_list "/uPlot.esm.js|${uplot}/dist/uPlot.esm.js" "/uPlot.min.css|${uplot}/dist/uPlot.min.css"
    "/uPlot.LICENSE.txt|${uplot}/LICENSE")
  list(TRANSFORM page_list REPLACE "^/index\\.html" "/")
  list(SORT page_list)
endif()

# The assembler copies the files (.incbin), which takes no compile time.
set(page_symbols "")
set(page_directives "")
set(page_rows "")
set(page_files "")
set(page_number 0)
set(type_of_.html "text/html; charset=utf-8")
set(type_of_.css "text/css; charset=utf-8")
set(type_of_.js "text/javascript; charset=utf-8")
set(type_of_ "text/plain; charset=utf-8")  # LICENSE
foreach(entry IN LISTS page_list)
  string(REGEX MATCH "^(.*)\\|(.*)$" entry "${entry}")
  set(path ${CMAKE_MATCH_1})
  set(file ${CMAKE_MATCH_2})
  cmake_path(GET file EXTENSION LAST_ONLY extension)
  list(APPEND page_files ${file})
  set(symbol hystcan_page_${page_number})
  string(APPEND page_symbols "extern \"C\" const char ${symbol}[], ${symbol}_end[];\n")
  string(APPEND page_directives
    ".global ${symbol}, ${symbol}_end\n${symbol}: .incbin \"${file}\"\n${symbol}_end: .byte 0\n")
  string(APPEND page_rows "      {\"${path}\", \"${type_of_${extension}}\", {${symbol}, ${symbol}_end}},\n")
  math(EXPR page_number "${page_number} + 1")
endforeach()
if(page_number EQUAL 0)
  set(page_body "  return {};\n")
else()
  set(page_body "  static const auto assets = std::to_array<Asset>({\n${page_rows}  });\n  return assets;\n")
endif()
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/page_assets.cpp @ONLY CONTENT [[
// Written by cmake/page_assets.cmake.
#include "app/page/assets.h"

#include <array>

asm(R"(
.pushsection .rodata
@page_directives@.popsection
)");

@page_symbols@
namespace hystcan::app {

std::span<const Asset> page_assets() {
@page_body@}

}  // namespace hystcan::app
]])
set_source_files_properties(${PROJECT_BINARY_DIR}/page_assets.cpp PROPERTIES OBJECT_DEPENDS "${page_files}")

add_library(hystcan_page_assets STATIC ${PROJECT_BINARY_DIR}/page_assets.cpp)
target_link_libraries(hystcan_page_assets PRIVATE hystcan_flags)
