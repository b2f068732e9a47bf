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

# What this machine has compiled once, no later clone compiles again: the cache sees paths below the checkout relative to the
# build folder, which is the same in each. The folder that debug information names may then be another clone's.
find_program(SINEW_CCACHE ccache)
if(SINEW_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
      CCACHE_SLOPPINESS=pch_defines,time_macros ${SINEW_CCACHE})
endif()
# Options of whatever uses a precompiled header: the cache has to see what was in it.
set(SINEW_CACHED_PRECOMPILED $<IF:$<CXX_COMPILER_ID:GNU>,-fpch-preprocess,SHELL:-Xclang -fno-pch-timestamp>)

add_compile_options(-Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Wold-style-cast
                    -Woverloaded-virtual -Wimplicit-fallthrough -Werror)
# Contraction to FMA and errno-setting libm calls would make two machines differ; see docs/design.md. Modules of other
# projects are compiled with these, too (cmake/SinewConfig.cmake.in).
set(SINEW_CODE_OPTIONS -fno-strict-aliasing -ffp-contract=off -fno-math-errno -fno-trapping-math)
add_compile_options(${SINEW_CODE_OPTIONS})
if(CMAKE_SIZEOF_VOID_P EQUAL 4)  # a 32-bit C library else counts seconds to 2038 and files to 2 GB
  set(SINEW_CODE_DEFINITIONS _TIME_BITS=64 _FILE_OFFSET_BITS=64)
  add_compile_definitions(${SINEW_CODE_DEFINITIONS})
endif()
# A robot locks its program into memory: what nobody calls is left out. Which functions those are only the linker knows.
add_compile_options(-ffunction-sections -fdata-sections)
add_link_options(-Wl,--gc-sections)

# Tests and sanitized programs, hundreds of them, are linked in a third of the time; what we give away has the linker
# that its sizes were measured with.
if(NOT CMAKE_CROSSCOMPILING)
  find_program(SINEW_FAST_LINKER ld.lld)
endif()
if(SINEW_FAST_LINKER)
  set(SINEW_FAST_LINK -fuse-ld=lld)
endif()

if(SINEW_SANITIZE)
  # -O1: a third less to compile, and the tests hardly notice. What gcc then suspects
  # of bounds and uninitialised variables is wrong too often; the optimised builds look for both.
  add_compile_options(-O1 -fsanitize=${SINEW_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-Wno-maybe-uninitialized -Wno-stringop-overflow)
  endif()
  add_link_options(-fsanitize=${SINEW_SANITIZE} ${SINEW_FAST_LINK})
endif()
if(SINEW_FUZZ)  # what is fuzzed is instrumented: sinew_room(), sinew_fuzz()
  add_link_options(-fsanitize=fuzzer-no-link)
endif()
