# Checks of the tree as a whole, as tests beside the others, so that one ctest run holds everything.
option(HYSTCAN_CHECKS "Register format, tidy, sanitizer and fuzz checks as tests" OFF)

# Gathers the test programs that have threads, for the thread sanitizer: add_dependencies(threads_tests PROGRAM).
add_custom_target(threads_tests)

# add_check(NAME TIMEOUT_S [PROCESSORS N]): `scripts/check NAME` as the test check.NAME.
function(add_check name timeout_s)
  cmake_parse_arguments(PARSE_ARGV 2 check "" "PROCESSORS" "")
  add_test(NAME check.${name} COMMAND ${PROJECT_SOURCE_DIR}/scripts/check ${name})
  set_tests_properties(check.${name} PROPERTIES LABELS check TIMEOUT ${timeout_s})
  if(check_PROCESSORS)
    set_tests_properties(check.${name} PROPERTIES PROCESSORS ${check_PROCESSORS})
  endif()
endfunction()

if(HYSTCAN_CHECKS)
  cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
  add_check(format 120)
  add_check(shell 120)
  add_check(tidy 2400 PROCESSORS ${cores})
  add_check(asan 2400 PROCESSORS ${cores})
  add_check(tsan 1800 PROCESSORS ${cores})
  add_check(fuzz 900 PROCESSORS ${cores})
  set_tests_properties(check.asan check.fuzz PROPERTIES RESOURCE_LOCK asan_build)
endif()
