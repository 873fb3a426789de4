# Man pages and shell completion, made by running the program: what a command takes is written once, in its sources.
find_program(HELP2MAN help2man)
if(HYSTCAN_SANITIZE)
  return()
endif()
set(terminal ${PROJECT_BINARY_DIR}/terminal)
set(made ${terminal}/hystcan.bash ${terminal}/_hystcan)
set(commands COMMAND ${CMAKE_COMMAND} -E make_directory ${terminal}
  COMMAND hystcan completion bash > ${terminal}/hystcan.bash
  COMMAND hystcan completion zsh > ${terminal}/_hystcan)
if(HELP2MAN)
  list(APPEND made ${terminal}/hystcan.1)
  find_program(LOWDOWN lowdown)
  if(LOWDOWN)
    list(APPEND made ${terminal}/hystcan.toml.5)
  else()
    message(STATUS "lowdown is not found: no man page of the configuration is made")
  endif()
  list(APPEND commands COMMAND ${PROJECT_SOURCE_DIR}/scripts/manpages $<TARGET_FILE:hystcan> ${PROJECT_VERSION} ${terminal})
else()
  message(STATUS "help2man is not found: no man pages are made")
endif()
file(GLOB pages CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/configuration/*.md)
add_custom_command(OUTPUT ${made} ${commands} DEPENDS hystcan
  ${PROJECT_SOURCE_DIR}/scripts/manpages ${PROJECT_SOURCE_DIR}/docs/configuration.md ${pages})
add_custom_target(hystcan_terminal ALL DEPENDS ${made})

# A build of the program alone has none of these.
install(FILES ${terminal}/hystcan.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME hystcan OPTIONAL)
install(FILES ${terminal}/_hystcan DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions OPTIONAL)
install(DIRECTORY ${terminal}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL FILES_MATCHING PATTERN *.1)
install(FILES ${terminal}/hystcan.toml.5 DESTINATION ${CMAKE_INSTALL_MANDIR}/man5 OPTIONAL)
