# Shared by the boards of this folder: Debian's cross compiler, a sysroot, and qemu-user for the tests.
set(CMAKE_SYSTEM_NAME Linux)

# Evaluated again for each try-compile, in a process that sees the environment but not the cache.
if(NOT SINEW_SYSROOT)
  set(SINEW_SYSROOT ${CMAKE_CURRENT_LIST_DIR}/../build/sysroot/${SINEW_BOARD})
  if(NOT "$ENV{SINEW_SYSROOTS}" STREQUAL "")
    set(SINEW_SYSROOT $ENV{SINEW_SYSROOTS}/${SINEW_BOARD})
  endif()
  get_filename_component(SINEW_SYSROOT ${SINEW_SYSROOT} ABSOLUTE)
endif()
if(NOT EXISTS ${SINEW_SYSROOT}/made-by)
  message(FATAL_ERROR "No sysroot for ${SINEW_BOARD} in ${SINEW_SYSROOT}. This makes it:\n"
                      "  tools/setup.sh cross ${SINEW_BOARD}\n")
endif()
find_program(SINEW_CROSS_CXX ${SINEW_TRIPLET}-g++)
if(NOT SINEW_CROSS_CXX)
  message(FATAL_ERROR "No ${SINEW_TRIPLET}-g++. This installs it, and the sysroot that goes with it:\n"
                      "  tools/setup.sh cross ${SINEW_BOARD}\n")
endif()

set(CMAKE_CXX_COMPILER ${SINEW_CROSS_CXX})
set(CMAKE_LIBRARY_ARCHITECTURE ${SINEW_TRIPLET})
set(CMAKE_SYSROOT ${SINEW_SYSROOT})
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SINEW_SYSROOT)
# Looks below the sysroot, and below the prefixes that a project names for an unpacked Sinew for the board.
set(CMAKE_FIND_ROOT_PATH ${SINEW_SYSROOT} ${CMAKE_PREFIX_PATH})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
# ctest starts programs through qemu-user; the build needs none. Tests read the variable (tests/include/qemu_user.hpp).
set(CMAKE_CROSSCOMPILING_EMULATOR ${SINEW_EMULATOR} -L ${SINEW_SYSROOT}
    -E "SINEW_QEMU_USER=${SINEW_EMULATOR} -L ${SINEW_SYSROOT}")
