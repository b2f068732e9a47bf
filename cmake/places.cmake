# Where things stand below an installed prefix. Libraries stand by machine, as Debian has them, whatever the prefix is: one
# layout for `cmake --install`, the packages and the tarballs, and find_package() looks there by itself.
set(SINEW_LIB_FOLDER lib)
if(CMAKE_LIBRARY_ARCHITECTURE)
  set(SINEW_LIB_FOLDER lib/${CMAKE_LIBRARY_ARCHITECTURE})
endif()
set(SINEW_CMAKE_FOLDER ${SINEW_LIB_FOLDER}/cmake/Sinew)  # SinewConfig.cmake
set(SINEW_PLUGIN_FOLDER ${SINEW_LIB_FOLDER}/sinew)       # what programs load by themselves
set(SINEW_INCLUDE_FOLDER include/sinew)                  # rt/, hal/, ...
set(SINEW_SHARE_FOLDER share/sinew)                      # robots/
set(SINEW_DOC_FOLDER share/doc/sinew)
