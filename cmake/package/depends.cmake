# cpack reads this before it makes packages: which of Debian's the programs need, looked up in what was built.
cmake_policy(VERSION 3.25)
if(NOT CPACK_GENERATOR STREQUAL DEB)
  return()
endif()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each has one of its own
set(command ${CPACK_SINEW_PYTHON} -B ${CPACK_SINEW_SOURCE}/tools/deb_depends.py)
if(CPACK_SINEW_SYSROOT)
  list(APPEND command --sysroot ${CPACK_SINEW_SYSROOT} --arch ${CPACK_SINEW_ARCH} --triplet ${CPACK_SINEW_TRIPLET})
endif()

# sinew_look_up(COMPONENT EXACT PROGRAMS [LOADED]): EXACT packages of ours; LOADED is a library that a program takes when it
# is there.
function(sinew_look_up component exact programs)
  set(recommends "")
  if(ARGN AND EXISTS ${ARGN})
    set(recommends --recommends ${ARGN})
  endif()
  execute_process(COMMAND ${command} --depends ${programs} ${recommends} OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCH "Depends: ([^\n]*)" _ "${said}")
  set(depends "${CMAKE_MATCH_1}")
  if(exact)
    string(APPEND depends ", ${exact}")
  endif()
  string(REGEX MATCH "Recommends: ([^\n]*)" _ "${said}")
  set(CPACK_DEBIAN_${component}_PACKAGE_RECOMMENDS "${CMAKE_MATCH_1}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${component}_PACKAGE_DEPENDS "${depends}" PARENT_SCOPE)
endfunction()

set(bin ${CPACK_SINEW_BUILD}/bin)
sinew_look_up(RUNTIME "" "${bin}/sinew;${bin}/sinew-fly;${bin}/sinew-control" ${bin}/libsinew_libcamera.so)
if(sim IN_LIST CPACK_COMPONENTS_ALL)
  sinew_look_up(SIM "sinew (= ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})" "${bin}/sinew-sim;${bin}/sinew-fuzz")
endif()
