# Windows by mingw-w64, run by Wine if there is no Windows: 64 bits, or 32 bits by windows32.cmake. See docs/windows.md.
if(NOT SINEW_WINDOWS_TRIPLET)
  set(SINEW_WINDOWS_TRIPLET x86_64-w64-mingw32)
endif()
set(CMAKE_SYSTEM_NAME Windows)
find_program(SINEW_CROSS_CXX ${SINEW_WINDOWS_TRIPLET}-g++-posix)
if(NOT SINEW_CROSS_CXX)
  set(SINEW_SETUP windows)
  if(SINEW_WINDOWS_TRIPLET MATCHES ^i686)
    set(SINEW_SETUP windows32)
  endif()
  message(FATAL_ERROR "No ${SINEW_WINDOWS_TRIPLET}-g++-posix. This installs it, and what goes with it:\n"
                      "  tools/setup.sh ${SINEW_SETUP}\n")
endif()
set(CMAKE_C_COMPILER ${SINEW_WINDOWS_TRIPLET}-gcc-posix)  # GoogleTest names C among its languages
set(CMAKE_CXX_COMPILER ${SINEW_WINDOWS_TRIPLET}-g++-posix)
set(CMAKE_RC_COMPILER ${SINEW_WINDOWS_TRIPLET}-windres)
set(CMAKE_FIND_ROOT_PATH /usr/${SINEW_WINDOWS_TRIPLET})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")  # one file: the compiler's own libraries are in it
if(SINEW_WINDOWS_TRIPLET MATCHES ^i686)
  set(CMAKE_SYSTEM_PROCESSOR i686)
  # SSE, since the x87 keeps 80 bits and gives other results than all other machines. SSE needs an alignment of 16 bytes,
  # but stacks of this system have 4, and its heap has 8 where the compiler assumes 16.
  # No -fipa-icf: a member function here removes its arguments from the stack itself, other functions leave that to their
  # caller. gcc 12 merges two such functions with equal bodies; a caller of the wrong kind then returns to an argument.
  set(CMAKE_C_FLAGS_INIT "-msse2 -mfpmath=sse -mstackrealign -fno-ipa-icf")
  set(CMAKE_CXX_FLAGS_INIT "-msse2 -mfpmath=sse -mstackrealign -fno-ipa-icf -faligned-new=8")
  set(CMAKE_CROSSCOMPILING_EMULATOR ${CMAKE_CURRENT_LIST_DIR}/wine32.sh)
else()
  set(CMAKE_SYSTEM_PROCESSOR x86_64)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${CMAKE_CURRENT_LIST_DIR}/wine.sh)
endif()
