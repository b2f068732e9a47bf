# 32-bit Windows by mingw-w64, run by Wine's 32-bit half if that can run here. See docs/windows.md.
set(SINEW_WINDOWS_TRIPLET i686-w64-mingw32)
include(${CMAKE_CURRENT_LIST_DIR}/windows.cmake)
