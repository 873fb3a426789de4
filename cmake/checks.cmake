# The checks of a change: `scripts/check NAME` is the test check.NAME of the configuration "check", and scripts/check
# runs all of them in one ctest run. The configuration "check_long", for scripts/check --long, also has the checks of a
# release. Each check uses half of the processors. The longest check (COST_S) begins first, so that no processor waits
# at the end.

# Collects the test programs with threads for the thread sanitizer: add_dependencies(threads_tests PROGRAM).
add_custom_target(threads_tests)

cmake_host_system_information(RESULT processors QUERY NUMBER_OF_LOGICAL_CORES)
math(EXPR check_jobs "(${processors} + 1) / 2")

# add_check(NAME TIMEOUT_S COST_S [CONFIGURATION...])
function(add_check name timeout_s cost_s)
  set(configurations ${ARGN})
  if(NOT configurations)
    set(configurations check check_long)
  endif()
  add_test(NAME check.${name} CONFIGURATIONS ${configurations}
    COMMAND ${CMAKE_COMMAND} -E env HYSTCAN_JOBS=${check_jobs} ${PROJECT_SOURCE_DIR}/scripts/check ${name})
  set_tests_properties(check.${name} PROPERTIES
    LABELS check TIMEOUT ${timeout_s} COST ${cost_s} PROCESSORS ${check_jobs})
endfunction()

add_check(asan 3600 900)
add_check(tidy 3600 600)
add_check(fuzz 1800 500)
add_check(tsan 2400 400)
add_check(mutants 2400 300)
add_check(package 3000 60)
add_check(benchmarks 900 60)
add_check(format 300 10)
add_check(layers 60 1)
add_check(names 60 1)
add_check(commits 60 1)
add_check(shell 300 10)
add_check(alerts 300 10)
add_check(firmware 300 10)
add_check(promises 60 1)
add_check(release 60 1)
add_check(evidence 60 1 check_long)
add_check(platforms 14400 1000 check_long)
add_check(site 300 30)
# Both build in build/asan.
set_tests_properties(check.fuzz PROPERTIES DEPENDS check.asan)
