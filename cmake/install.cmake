# The installed files beside the rooms (cmake/export.cmake). Four components: runtime for a robot's computer, monitor to
# look inside from a browser, dev for a compiler, sim to fly without a robot.
set(SINEW_INSTALLED_PROGRAMS "")
function(sinew_install_program target component)
  if(TARGET ${target})
    install(TARGETS ${target} RUNTIME DESTINATION bin COMPONENT ${component})
    set(SINEW_INSTALLED_PROGRAMS ${SINEW_INSTALLED_PROGRAMS} ${target} PARENT_SCOPE)
    set(SINEW_PROGRAMS_OF_${component} ${SINEW_PROGRAMS_OF_${component}} ${target} PARENT_SCOPE)
  endif()
endfunction()
sinew_install_program(sinew runtime)
sinew_install_program(sinew-fly runtime)
sinew_install_program(sinew-control runtime)
sinew_install_program(sinew-monitor monitor)
if(TARGET sinew-sim)
  sinew_install_program(sinew-sim sim)
  sinew_install_program(sinew-fuzz sim)
endif()
if(TARGET sinew_libcamera)
  install(TARGETS sinew_libcamera LIBRARY DESTINATION ${SINEW_PLUGIN_FOLDER} COMPONENT runtime)
  list(APPEND SINEW_INSTALLED_PROGRAMS sinew_libcamera)
endif()

# libsinew_client.so for programs beside a robot, with what Python needs of it; the header and the link for compilers.
if(TARGET sinew_client_library)
  install(TARGETS sinew_client_library LIBRARY DESTINATION ${SINEW_LIB_FOLDER} COMPONENT runtime NAMELINK_SKIP)
  install(TARGETS sinew_client_library LIBRARY DESTINATION ${SINEW_LIB_FOLDER} COMPONENT dev NAMELINK_ONLY)
  install(FILES client/sinew_client.h DESTINATION include COMPONENT dev)
  install(FILES client/mex/sinew_mex.c DESTINATION ${SINEW_SHARE_FOLDER}/mex COMPONENT dev)
  install(DIRECTORY python/sinew DESTINATION lib/python3/dist-packages COMPONENT runtime
          FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
  list(APPEND SINEW_INSTALLED_PROGRAMS sinew_client_library)
endif()

file(GLOB documents CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/*.md)
list(FILTER documents EXCLUDE REGEX "/README.md$")
file(GLOB reference CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/reference/*.md)
if(WIN32)  # an unpacked folder, not a prefix
  install(DIRECTORY robots/ DESTINATION robots COMPONENT runtime FILES_MATCHING PATTERN "*.toml" PATTERN world EXCLUDE)
  install(FILES ${documents} DESTINATION docs COMPONENT runtime)
  install(FILES ${reference} DESTINATION docs/reference COMPONENT runtime)
  install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION . COMPONENT runtime)
  return()
endif()
install(DIRECTORY robots/ DESTINATION ${SINEW_SHARE_FOLDER}/robots COMPONENT runtime FILES_MATCHING PATTERN "*.toml" PATTERN world EXCLUDE)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${documents} DESTINATION ${SINEW_DOC_FOLDER} COMPONENT dev)
install(FILES ${reference} DESTINATION ${SINEW_DOC_FOLDER}/reference COMPONENT dev)

# The shell's completion is the output of `sinew completion bash`; a board's program runs in qemu-user for that.
set(completion ${CMAKE_BINARY_DIR}/package/completion/sinew)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/package/completion)
add_custom_command(OUTPUT ${completion} COMMAND sinew completion bash > ${completion} DEPENDS sinew VERBATIM)
add_custom_target(sinew_completion DEPENDS ${completion})
install(FILES ${completion} DESTINATION share/bash-completion/completions COMPONENT runtime)

# A manual page of each program, made from its --help.
find_package(Python3 QUIET COMPONENTS Interpreter)
if(NOT Python3_FOUND)
  message(STATUS "manual pages: not made, Python makes them")
endif()
set(pages "")
function(sinew_manual_page target component what)
  if(NOT TARGET ${target} OR NOT Python3_FOUND)
    return()
  endif()
  set(tool ${PROJECT_SOURCE_DIR}/tools/manual_page.py)
  set(page ${CMAKE_BINARY_DIR}/package/man/${target}.1.gz)
  add_custom_command(
    OUTPUT ${page}
    COMMAND ${Python3_EXECUTABLE} -B ${tool} --name ${target} --what ${what} --version ${PROJECT_VERSION} --into ${page} --
            ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:${target}>
    DEPENDS ${target} ${tool} VERBATIM)
  install(FILES ${page} DESTINATION share/man/man1 COMPONENT ${component})
  set(pages ${pages} ${page} PARENT_SCOPE)
endfunction()
sinew_manual_page(sinew runtime "runs, checks, records and repeats robots")
sinew_manual_page(sinew-fly runtime "flies a robot file against a simulator in lockstep")
sinew_manual_page(sinew-control runtime "the smallest robot that controls something")
sinew_manual_page(sinew-monitor monitor "shows robots to browsers and other programs")
sinew_manual_page(sinew-sim sim "simulated worlds in place of a robot's devices")
sinew_manual_page(sinew-fuzz sim "looks for flights that go wrong")
add_custom_target(sinew_manual_pages DEPENDS ${pages})

install(FILES ${PROJECT_SOURCE_DIR}/cmake/package/sinew@.service DESTINATION lib/systemd/system COMPONENT runtime)
