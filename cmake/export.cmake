# What find_package(Sinew) needs, written into the build folder: a project outside sets Sinew_DIR to it. Included last,
# when all rooms are known.
get_property(rooms GLOBAL PROPERTY SINEW_ROOMS)
export(TARGETS ${rooms} NAMESPACE sinew:: FILE ${CMAKE_BINARY_DIR}/SinewTargets.cmake)
configure_file(${CMAKE_CURRENT_LIST_DIR}/SinewConfig.cmake.in ${CMAKE_BINARY_DIR}/SinewConfig.cmake @ONLY)
