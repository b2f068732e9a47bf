# Folders below an installed prefix. Libraries have a folder for each machine, as in Debian, with any prefix: one layout
# for `cmake --install`, the packages and the tarballs, in which find_package() looks without being told.
set(SINEW_LIB_FOLDER lib)
if(CMAKE_LIBRARY_ARCHITECTURE)
  set(SINEW_LIB_FOLDER lib/${CMAKE_LIBRARY_ARCHITECTURE})
endif()
set(SINEW_CMAKE_FOLDER ${SINEW_LIB_FOLDER}/cmake/Sinew)  # SinewConfig.cmake
set(SINEW_PLUGIN_FOLDER ${SINEW_LIB_FOLDER}/sinew)       # loaded by programs on demand
set(SINEW_INCLUDE_FOLDER include/sinew)                  # rt/, hal/, ...
set(SINEW_SHARE_FOLDER share/sinew)                      # robots/
set(SINEW_DOC_FOLDER share/doc/sinew)
