# Packages: `cmake --build build/PRESET --target packages` builds their content and writes them to
# build/PRESET/packages, each with its bill of materials. See docs/packages.md.
set(SINEW_PACKAGE_CONTACT "The Sinew authors <sinew@example.org>" CACHE STRING "Maintainer in the packages' fields")
set(CPACK_PACKAGE_NAME sinew)
set(CPACK_PACKAGE_VENDOR "The Sinew authors")
set(CPACK_PACKAGE_CONTACT ${SINEW_PACKAGE_CONTACT})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL runtime dev)
foreach(component monitor net sim)
  if(TARGET sinew-${component})
    list(APPEND CPACK_COMPONENTS_ALL ${component})
  endif()
endforeach()

# The kind of package, and the machine by Debian's name.
set(SINEW_PACKAGE_ARCH ${SINEW_BOARD})
if(NOT SINEW_BOARD AND NOT WIN32)
  if(NOT CMAKE_CROSSCOMPILING)  # with another toolchain file, for a machine that dpkg does not know
    execute_process(COMMAND dpkg --print-architecture OUTPUT_VARIABLE SINEW_PACKAGE_ARCH OUTPUT_STRIP_TRAILING_WHITESPACE
                    ERROR_QUIET)
  endif()
  if(NOT SINEW_PACKAGE_ARCH)
    set(SINEW_PACKAGE_ARCH ${CMAKE_SYSTEM_PROCESSOR})
  endif()
endif()
if(WIN32)
  string(REPLACE _ - SINEW_PACKAGE_ARCH windows-${CMAKE_SYSTEM_PROCESSOR})
  set(CPACK_GENERATOR ZIP)
  set(CPACK_COMPONENTS_ALL runtime)
elseif(SINEW_PACKAGE_ARCH MATCHES "^(amd64|arm64|armhf)$")
  set(CPACK_GENERATOR DEB)
else()  # mipsel: a board with that processor seldom runs Debian, and Debian 13 dropped it
  set(CPACK_GENERATOR TGZ)
endif()
set(SINEW_PACKAGE_KIND "" CACHE STRING "DEB or TGZ, where another kind is wanted than the machine's usual one")
if(SINEW_PACKAGE_KIND)
  set(CPACK_GENERATOR ${SINEW_PACKAGE_KIND})
endif()
set(CPACK_PACKAGE_FILE_NAME sinew-${PROJECT_VERSION}-${SINEW_PACKAGE_ARCH})
if(NOT CPACK_GENERATOR STREQUAL DEB)
  set(CPACK_INCLUDE_TOPLEVEL_DIRECTORY ON)
  set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
  set(CPACK_ARCHIVE_COMPONENT_INSTALL ON)
  set(CPACK_COMPONENT_INCLUDE_TOPLEVEL_DIRECTORY ON)
endif()

# Debian's fields. cmake/package/depends.cmake looks up the packages that the programs need when packages are made.
set(SINEW_DEB_VERSION ${PROJECT_VERSION}-1)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${SINEW_PACKAGE_ARCH})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SOURCE "sinew (${SINEW_DEB_VERSION})")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME sinew)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "sinew-monitor, sinew-net, sinew-sim, libsinew-dev")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${CMAKE_BINARY_DIR}/package/triggers)  # for libsinew_client.so.1
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/package/triggers CONTENT "activate-noawait ldconfig\n")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "runtime of a robot's onboard computer
The sinew command runs, checks, records and repeats robots that are described
by a file: drivers, estimation, control and vision as modules with fixed
priorities, in real time or in virtual time against a simulator.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libsinew-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "sinew (= ${SINEW_DEB_VERSION})")  # libsinew_client.so is a link to its file
set(CPACK_COMPONENT_DEV_DESCRIPTION "runtime of robots, to write modules for
Headers, static libraries and the CMake package of Sinew, for programs with
modules of one's own. The command \"sinew new\" writes such a project.")
set(CPACK_DEBIAN_MONITOR_PACKAGE_NAME sinew-monitor)
set(CPACK_DEBIAN_MONITOR_PACKAGE_SECTION misc)
set(CPACK_COMPONENT_MONITOR_DESCRIPTION "robots of the Sinew runtime in a browser
Serves a page, pictures and the Foxglove WebSocket protocol for the robots of
this machine. Nothing of it runs in a robot's process.")
set(CPACK_DEBIAN_NET_PACKAGE_NAME sinew-net)
set(CPACK_DEBIAN_NET_PACKAGE_SECTION misc)
set(CPACK_COMPONENT_NET_DESCRIPTION "DDS for robots of the Sinew runtime
A program beside the robot that has a DDS participant: the team's radio, and
the robot as a node of a ROS 2 graph.")
set(CPACK_DEBIAN_SIM_PACKAGE_NAME sinew-sim)
set(CPACK_DEBIAN_SIM_PACKAGE_SECTION misc)
set(with_fuzz "")
if(TARGET sinew-fuzz)  # a desk's program
  set(with_fuzz "\nWith it comes sinew-fuzz, which looks for flights that go wrong,\nand sinew-learn, which learns to land.")
endif()
set(CPACK_COMPONENT_SIM_DESCRIPTION "simulator for robots of the Sinew runtime
A simulated world on MuJoCo that stands in for every device of a robot, with
its camera, in lockstep or in real time.${with_fuzz}")

# The dev package depends on the libraries of sinew::apps and its rooms, which find_package(Sinew COMPONENTS apps) looks
# for. It only suggests the libraries of other rooms.
set(wanted libc6-dev libstdc++-12-dev)
set(suggested cmake)
if(CPACK_GENERATOR STREQUAL DEB)
  sinew_needs(sinew::apps needs)
  foreach(need ${needs})
    sinew_debian_package(${need} package)
    if(NOT package)
      message(FATAL_ERROR "packages: ${need}: its Debian package is not named in cmake/externals.cmake")
    endif()
    list(APPEND wanted ${package})
  endforeach()
  foreach(room hal_linux_libcamera vision_opencv)
    if(TARGET sinew::${room})
      sinew_needs(sinew::${room} needs)
      foreach(need ${needs})
        sinew_debian_package(${need} package)
        list(APPEND suggested ${package})
      endforeach()
    endif()
  endforeach()
  list(REMOVE_ITEM suggested ${wanted})
endif()
list(REMOVE_DUPLICATES wanted)
list(REMOVE_DUPLICATES suggested)
list(JOIN wanted ", " CPACK_DEBIAN_DEV_PACKAGE_DEPENDS)
list(JOIN suggested ", " CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS)

# External code in our programs, mostly headers, goes with its licence, taken from its Debian package.
set(others libtomlplusplus-dev nlohmann-json3-dev)
if(NOT WIN32)
  list(APPEND others libcli11-dev)
else()  # headers of fmt instead of its library, and the compiler's libraries by -static
  list(APPEND others libfmt-dev)
  string(REGEX REPLACE "-w64-mingw32$" "" machine ${SINEW_WINDOWS_TRIPLET})
  string(REPLACE _ - machine ${machine})
  list(APPEND others mingw-w64-${machine}-dev gcc-mingw-w64-${machine}-posix g++-mingw-w64-${machine}-posix)
endif()
set(SINEW_NOTICES "")
foreach(package ${others})
  set(licence ${CMAKE_SYSROOT}/usr/share/doc/${package}/copyright)
  if(EXISTS ${licence})
    configure_file(${licence} ${CMAKE_BINARY_DIR}/package/third-party/${package}.txt COPYONLY)
    list(APPEND SINEW_NOTICES ${CMAKE_BINARY_DIR}/package/third-party/${package}.txt)
  else()
    message(STATUS "packages: without the licence of ${package}: ${licence} is missing")
  endif()
endforeach()

# Every Debian package has these two files. SOURCE_DATE_EPOCH fixes the date.
if(CPACK_GENERATOR STREQUAL DEB)
  string(TIMESTAMP SINEW_PACKAGE_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
  file(READ LICENSE licence)
  string(REGEX MATCH "Copyright [^\n]*" SINEW_COPYRIGHT "${licence}")
  string(REGEX REPLACE "^Copyright (\\(c\\) )?" "" SINEW_COPYRIGHT "${SINEW_COPYRIGHT}")
  string(REGEX REPLACE "^.*(Redistribution and use)" "\\1" licence "${licence}")
  string(REPLACE "\n\n" "\n.\n" licence "${licence}")
  string(REGEX REPLACE "\n+$" "" licence "${licence}")
  string(REPLACE "\n" "\n " SINEW_LICENCE_TEXT " ${licence}")
  set(folder ${CMAKE_BINARY_DIR}/package/doc)
  configure_file(cmake/package/copyright.in ${folder}/copyright @ONLY)
  configure_file(cmake/package/changelog.in ${folder}/changelog.Debian @ONLY)
  execute_process(COMMAND gzip -9nkf ${folder}/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)
  foreach(pair runtime:sinew dev:libsinew-dev monitor:sinew-monitor net:sinew-net sim:sinew-sim)
    string(REPLACE ":" ";" pair ${pair})
    list(GET pair 0 component)
    list(GET pair 1 package)
    install(FILES ${folder}/copyright ${folder}/changelog.Debian.gz DESTINATION share/doc/${package}
            COMPONENT ${component})
    install(FILES ${SINEW_NOTICES} DESTINATION share/doc/${package}/third-party COMPONENT ${component})
  endforeach()
elseif(WIN32)
  install(FILES ${SINEW_NOTICES} DESTINATION third-party COMPONENT runtime)
else()  # the licences go where the programs go
  install(FILES LICENSE DESTINATION ${SINEW_DOC_FOLDER} COMPONENT runtime)
  install(FILES ${SINEW_NOTICES} DESTINATION ${SINEW_DOC_FOLDER}/third-party COMPONENT runtime)
endif()

# For the two scripts that run while packages are made.
find_package(Python3 QUIET COMPONENTS Interpreter)
set(CPACK_SINEW_PYTHON ${Python3_EXECUTABLE})
set(CPACK_SINEW_SOURCE ${PROJECT_SOURCE_DIR})
set(CPACK_SINEW_BUILD ${CMAKE_BINARY_DIR})
set(CPACK_SINEW_SYSROOT ${CMAKE_SYSROOT})
set(CPACK_SINEW_ARCH ${SINEW_PACKAGE_ARCH})
set(CPACK_SINEW_TRIPLET ${CMAKE_LIBRARY_ARCHITECTURE})
set(CPACK_SINEW_RUNTIME_PROGRAMS ${SINEW_PROGRAMS_OF_runtime})
set(CPACK_SINEW_MONITOR_PROGRAMS ${SINEW_PROGRAMS_OF_monitor})
set(CPACK_SINEW_NET_PROGRAMS ${SINEW_PROGRAMS_OF_net})
set(CPACK_SINEW_SIM_PROGRAMS ${SINEW_PROGRAMS_OF_sim})
set(CPACK_SINEW_STATIC "")
if(WIN32)  # the compiler's libraries that -static links
  foreach(library libstdc++.a libgcc.a libgcc_eh.a libwinpthread.a libmingwex.a)
    execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=${library} OUTPUT_VARIABLE path
                    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    list(APPEND CPACK_SINEW_STATIC ${path})
  endforeach()
endif()
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/package/depends.cmake)
set(CPACK_POST_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/package/describe.cmake)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # tests are not installed; the target below names the installed targets
include(CPack)
set(contents ${SINEW_INSTALLED_PROGRAMS})
if(NOT WIN32)
  get_property(rooms GLOBAL PROPERTY SINEW_INSTALLED_ROOMS)
  list(APPEND contents ${rooms} sinew_completion sinew_manual_pages)
endif()
add_custom_target(installed)
add_dependencies(installed ${contents})
add_custom_target(packages
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${CPACK_PACKAGE_DIRECTORY}
  COMMAND ${CMAKE_CPACK_COMMAND} --config ${CMAKE_BINARY_DIR}/CPackConfig.cmake
  WORKING_DIRECTORY ${CMAKE_BINARY_DIR} USES_TERMINAL VERBATIM)
add_dependencies(packages installed)
