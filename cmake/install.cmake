# What an installed Sinew has beside the rooms (cmake/export.cmake). Three components: runtime is what a robot's computer
# needs, dev what a compiler needs, sim what flies without a robot.
set(SINEW_INSTALLED_PROGRAMS "")
function(sinew_install_program target component)
  if(TARGET ${target})
    install(TARGETS ${target} RUNTIME DESTINATION bin COMPONENT ${component})
    set(SINEW_INSTALLED_PROGRAMS ${SINEW_INSTALLED_PROGRAMS} ${target} PARENT_SCOPE)
  endif()
endfunction()
sinew_install_program(sinew runtime)
sinew_install_program(sinew-fly runtime)
if(TARGET sinew-sim AND NOT CMAKE_CROSSCOMPILING)  # for a board it is built for the VM bench, and is a desk's program
  sinew_install_program(sinew-sim sim)
  sinew_install_program(sinew-fuzz sim)
endif()
if(TARGET sinew_libcamera)
  install(TARGETS sinew_libcamera LIBRARY DESTINATION ${SINEW_PLUGIN_FOLDER} COMPONENT runtime)
  list(APPEND SINEW_INSTALLED_PROGRAMS sinew_libcamera)
endif()

file(GLOB robots CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/robots/*.toml ${PROJECT_SOURCE_DIR}/robots/*.xml)
file(GLOB documents CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/*.md)
if(WIN32)  # an unpacked folder, not a prefix
  install(FILES ${robots} DESTINATION robots COMPONENT runtime)
  install(FILES ${documents} DESTINATION docs COMPONENT runtime)
  install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION . COMPONENT runtime)
  return()
endif()
install(FILES ${robots} DESTINATION ${SINEW_SHARE_FOLDER}/robots COMPONENT runtime)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${documents} DESTINATION ${SINEW_DOC_FOLDER} COMPONENT dev)

# The shell's completion is what `sinew completion bash` prints; of a board's program in qemu-user.
set(completion ${CMAKE_BINARY_DIR}/package/completion/sinew)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/package/completion)
add_custom_command(OUTPUT ${completion} COMMAND sinew completion bash > ${completion} DEPENDS sinew VERBATIM)
add_custom_target(sinew_completion DEPENDS ${completion})
install(FILES ${completion} DESTINATION share/bash-completion/completions COMPONENT runtime)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/package/sinew@.service DESTINATION lib/systemd/system COMPONENT runtime)
