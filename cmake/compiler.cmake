# Language, warnings and the floating-point rules that give the same bits everywhere.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -g1")

# Later clones on this machine compile no file again: the cache sees paths below the checkout relative to the build
# folder, which are the same in each clone. Debug information may then name the folder of another clone.
find_program(SINEW_CCACHE ccache)
if(SINEW_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
      CCACHE_SLOPPINESS=pch_defines,time_macros ${SINEW_CCACHE})
endif()
# Options of targets with a precompiled header: the cache has to see the content of that header.
set(SINEW_CACHED_PRECOMPILED $<IF:$<CXX_COMPILER_ID:GNU>,-fpch-preprocess,SHELL:-Xclang -fno-pch-timestamp>)

add_compile_options(-Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Wold-style-cast
                    -Woverloaded-virtual -Wimplicit-fallthrough -Werror)
# Contraction to FMA and errno-setting libm calls would make two machines differ; see docs/design.md. Modules of other
# projects get the same options (cmake/SinewConfig.cmake.in).
set(SINEW_CODE_OPTIONS -fno-strict-aliasing -ffp-contract=off -fno-math-errno -fno-trapping-math)
add_compile_options(${SINEW_CODE_OPTIONS})
if(CMAKE_SIZEOF_VOID_P EQUAL 4)  # else a 32-bit C library counts seconds only to 2038 and files only to 2 GB
  set(SINEW_CODE_DEFINITIONS _TIME_BITS=64 _FILE_OFFSET_BITS=64)
  add_compile_definitions(${SINEW_CODE_DEFINITIONS})
endif()
# A robot locks its program into memory, so the linker leaves out functions that are never called.
add_compile_options(-ffunction-sections -fdata-sections)
add_link_options(-Wl,--gc-sections)

# lld links the hundreds of tests and sanitized programs in a third of the time. Released programs keep the linker that
# their sizes were measured with.
if(NOT CMAKE_CROSSCOMPILING)
  find_program(SINEW_FAST_LINKER ld.lld)
endif()
if(SINEW_FAST_LINKER)
  set(SINEW_FAST_LINK -fuse-ld=lld)
endif()

if(SINEW_SANITIZE)
  # -O1: a third less to compile, and hardly slower tests. With it gcc's warnings about bounds and uninitialised
  # variables are wrong too often; the optimised builds check both.
  add_compile_definitions(SINEW_SANITIZED)  # gcc and clang have no name in common
  add_compile_options(-O1 -fsanitize=${SINEW_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-Wno-maybe-uninitialized -Wno-stringop-overflow)
  endif()
  add_link_options(-fsanitize=${SINEW_SANITIZE} ${SINEW_FAST_LINK})
endif()
if(SINEW_FUZZ)  # sinew_room() and sinew_fuzz() instrument the fuzzed code
  add_link_options(-fsanitize=fuzzer-no-link)
endif()
