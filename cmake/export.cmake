# The files for find_package(Sinew), in the build folder and in an installed prefix: another project names one of these
# two in CMAKE_PREFIX_PATH. Included last, when all rooms are known.
include(CMakePackageConfigHelpers)

# sinew_package(FOLDER ROOMS PROGRAMS): SinewConfig.cmake and its version, for one of the two places.
function(sinew_package folder rooms SINEW_PROGRAMS_FROM_PACKAGE)
  list(TRANSFORM rooms REPLACE "^sinew_" "" OUTPUT_VARIABLE SINEW_ROOM_NAMES)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/SinewConfig.cmake.in ${folder}/SinewConfig.cmake @ONLY)
  write_basic_package_version_file(${folder}/SinewConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  # Libraries of another machine do not fit; the size of a pointer alone does not show that.
  file(APPEND ${folder}/SinewConfigVersion.cmake "
set(PACKAGE_SINEW_ARCHITECTURE \"${CMAKE_LIBRARY_ARCHITECTURE}\")
if(CMAKE_LIBRARY_ARCHITECTURE AND NOT CMAKE_LIBRARY_ARCHITECTURE STREQUAL PACKAGE_SINEW_ARCHITECTURE)
  set(PACKAGE_VERSION \"\${PACKAGE_VERSION} (\${PACKAGE_SINEW_ARCHITECTURE})\")
  set(PACKAGE_VERSION_UNSUITABLE TRUE)
endif()
")
  configure_file(${PROJECT_SOURCE_DIR}/cmake/externals.cmake ${folder}/SinewExternals.cmake COPYONLY)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/set_aside.cmake ${folder}/SinewSetAside.cmake COPYONLY)
endfunction()

get_property(rooms GLOBAL PROPERTY SINEW_ROOMS)
export(TARGETS ${rooms} NAMESPACE sinew:: FILE ${CMAKE_BINARY_DIR}/SinewTargets.cmake)
sinew_package(${CMAKE_BINARY_DIR} "${rooms}" bin)

get_property(rooms GLOBAL PROPERTY SINEW_INSTALLED_ROOMS)
file(RELATIVE_PATH programs /${SINEW_CMAKE_FOLDER} /bin)
sinew_package(${CMAKE_BINARY_DIR}/package "${rooms}" ${programs})
install(FILES ${CMAKE_BINARY_DIR}/package/SinewConfig.cmake ${CMAKE_BINARY_DIR}/package/SinewConfigVersion.cmake
              ${CMAKE_BINARY_DIR}/package/SinewExternals.cmake ${CMAKE_BINARY_DIR}/package/SinewSetAside.cmake
        DESTINATION ${SINEW_CMAKE_FOLDER} COMPONENT dev)
install(TARGETS ${rooms} EXPORT SinewTargets ARCHIVE DESTINATION ${SINEW_LIB_FOLDER} COMPONENT dev)
install(EXPORT SinewTargets NAMESPACE sinew:: DESTINATION ${SINEW_CMAKE_FOLDER} COMPONENT dev)
# Strips debug information, which names folders of this machine; linkers need the rest.
if(CMAKE_STRIP)
  install(CODE "file(GLOB libraries \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${SINEW_LIB_FOLDER}/libsinew_*.a\")
foreach(library IN LISTS libraries)
  execute_process(COMMAND \"${CMAKE_STRIP}\" --strip-debug --remove-section=.comment --enable-deterministic-archives
                          \${library} COMMAND_ERROR_IS_FATAL ANY)
endforeach()" COMPONENT dev)
endif()
