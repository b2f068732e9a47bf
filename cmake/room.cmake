# sinew_batches(TARGET [SIZE]): compiles its sources SIZE (16) at a time, so that headers are read once for each batch.
# Names in unnamed namespaces must then differ within a room; SKIP_UNITY_BUILD_INCLUSION keeps one file out.
function(sinew_batches target)
  if(NOT SINEW_BATCHES)
    return()
  endif()
  set(size 16)
  if(ARGC GREATER 1)
    set(size ${ARGV1})
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${size})
  # gcc warns about types of an unnamed namespace in an included file; a batch includes source files, where that is
  # fine.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()

# sinew_batch(TARGET NAME REGEX...): makes one batch of the sources with these names, so that a program that needs only
# other sources of the room does not link the libraries of these. A source in no batch is then compiled separately.
function(sinew_batch target name)
  if(NOT SINEW_BATCHES)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(JOIN ARGN "|" pattern)
  list(FILTER sources INCLUDE REGEX "(^|/)(${pattern})[.]cpp$")
  if(sources)  # a file may be left out for a system
    set_source_files_properties(${sources} PROPERTIES UNITY_GROUP ${name})
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()

# The table of rooms: SINEW_ROOM_PATHS in its order, and SINEW_SEES_name of each.
set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/rooms.txt)
file(STRINGS ${PROJECT_SOURCE_DIR}/cmake/rooms.txt lines REGEX "^[a-z]")
set(SINEW_ROOM_PATHS "")
foreach(line ${lines})
  if(NOT line MATCHES "^([a-z0-9_/*]+):([a-z0-9_/* ]*)[|] .")
    message(FATAL_ERROR "cmake/rooms.txt: ${line}: a line is 'room: rooms that it sees | what it holds'")
  endif()
  set(path ${CMAKE_MATCH_1})
  string(STRIP "${CMAKE_MATCH_2}" sees)
  string(REPLACE / _ name ${path})
  string(REPLACE / _ sees "${sees}")
  string(REPLACE " " ";" SINEW_SEES_${name} "${sees}")
  list(APPEND SINEW_ROOM_PATHS ${path})
endforeach()

# sinew_room(PATH [SOURCES ...] [LIBS ...] [PRIVATE_LIBS ...] [HEADERS_OF ...] [INTERNAL]): one static library for one
# folder, `sinew_hal_linux` for hal/linux, of all its sources unless some are named. cmake/rooms.txt says which rooms it
# sees. HEADERS_OF names external header libraries that only the room's own sources include: programs that link the room
# do not need them. INTERNAL: not installed.
#
# Only the headers of rooms that are linked can be included, because each room's include path holds links to that
# room's own headers and to nothing else: `#include "rt/topic.hpp"` needs rt in the table's line. Always write the room's
# path in an include, also inside the room.
function(sinew_room path)
  cmake_parse_arguments(ARG "INTERNAL;HEADERS_ONLY" "" "SOURCES;LIBS;PRIVATE_LIBS;HEADERS_OF" ${ARGN})
  string(REPLACE / _ name ${path})
  if(NOT path IN_LIST SINEW_ROOM_PATHS)  # the line with * in place of its second folder
    string(REGEX REPLACE "^([^/]+)/([^/]+)" "\\1/*" pattern ${path})
    string(REPLACE / _ pattern_name ${pattern})
    set(SINEW_SEES_${name} ${SINEW_SEES_${pattern_name}})
    list(TRANSFORM SINEW_SEES_${name} REPLACE "[*]" "${CMAKE_MATCH_2}")
  endif()
  if(NOT path IN_LIST SINEW_ROOM_PATHS AND NOT pattern IN_LIST SINEW_ROOM_PATHS)
    message(FATAL_ERROR "${path}: not in cmake/rooms.txt, which says what each room may include")
  endif()
  if(NOT ARG_SOURCES AND NOT ARG_HEADERS_ONLY)
    file(GLOB ARG_SOURCES CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/${path}/*.cpp)
  endif()
  set(gate ${CMAKE_BINARY_DIR}/include/${name})
  file(GLOB headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/${path} ${PROJECT_SOURCE_DIR}/${path}/*.hpp ${PROJECT_SOURCE_DIR}/${path}/*.h)
  list(REMOVE_ITEM headers precompiled.hpp)  # for the compiler; no file includes it
  file(REMOVE_RECURSE ${gate})
  file(MAKE_DIRECTORY ${gate}/${path})
  foreach(header ${headers})
    file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${path}/${header} ${gate}/${path}/${header} SYMBOLIC)
  endforeach()
  if(ARG_SOURCES)
    add_library(sinew_${name} STATIC ${ARG_SOURCES})
    set(scope PUBLIC)
  else()
    add_library(sinew_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(sinew::${name} ALIAS sinew_${name})
  set_target_properties(sinew_${name} PROPERTIES EXPORT_NAME ${name})
  set_property(GLOBAL APPEND PROPERTY SINEW_ROOMS sinew_${name})
  target_include_directories(sinew_${name} ${scope} $<BUILD_INTERFACE:${gate}> $<INSTALL_INTERFACE:${SINEW_INCLUDE_FOLDER}>)
  if(NOT ARG_INTERNAL)
    set_property(GLOBAL APPEND PROPERTY SINEW_INSTALLED_ROOMS sinew_${name})
    list(TRANSFORM headers PREPEND ${PROJECT_SOURCE_DIR}/${path}/)
    install(FILES ${headers} DESTINATION ${SINEW_INCLUDE_FOLDER}/${path} COMPONENT dev)
  endif()
  foreach(room ${SINEW_SEES_${name}})
    if(room STREQUAL robots AND path MATCHES "^robots/")  # the list of robots links them
      target_include_directories(sinew_${name} PRIVATE $<TARGET_PROPERTY:sinew_robots,INTERFACE_INCLUDE_DIRECTORIES>)
    else()
      target_link_libraries(sinew_${name} ${scope} sinew::${room})
    endif()
  endforeach()
  target_link_libraries(sinew_${name} ${scope} ${ARG_LIBS})
  if(ARG_SOURCES)
    sinew_batches(sinew_${name})
    target_link_libraries(sinew_${name} PRIVATE ${ARG_PRIVATE_LIBS})
    foreach(other ${ARG_HEADERS_OF})
      target_include_directories(sinew_${name} SYSTEM PRIVATE $<TARGET_PROPERTY:${other},INTERFACE_INCLUDE_DIRECTORIES>)
    endforeach()
    # Code must assemble numbers of devices and files from bytes, never cast in place: boards do not read across words.
    # Only rt, tap and hal/linux may cast, since their memory (topics, rings) is aligned.
    if(CMAKE_CROSSCOMPILING AND NOT WIN32 AND NOT path STREQUAL record/run AND
       path MATCHES "^(math|msg|wire|hal|control|vision|record|dataset|drivers|sim_hil|robots)(/|$)" AND NOT path MATCHES "^hal/linux")
      target_compile_options(sinew_${name} PRIVATE -Wcast-align=strict)
    endif()
    if(SINEW_FUZZ AND (NOT path MATCHES "^apps($|/)" OR path MATCHES "^apps/(toml|robot_file)$"))  # no fuzzer runs commands
      target_compile_options(sinew_${name} PRIVATE -fsanitize=fuzzer-no-link)
    endif()
  endif()
endfunction()

# sinew_test(NAME SOURCES ... USES room... [LIBS ...] [ALONE] [TIMEOUT s] [EMULATED_SHARDS n]): GoogleTest cases. On the
# host the tests of a folder are compiled in batches and linked into one program, `rt_tests` for tests/rt; ALONE keeps a
# test out of it that replaces calls or links a library that the others shall not have. NAME is a program of these cases
# only. It is built on demand, and always for a board or Windows; there it is one test (one of n shards in an emulator),
# since the emulator takes longer to start than most cases run. Does nothing in a build without SINEW_TESTS (the
# fuzzers'). A folder whose room has only headers, which only the tests compile, sets SINEW_ROOM_IS_HEADERS.
function(sinew_test name)
  if(NOT SINEW_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "ALONE" "TIMEOUT;EMULATED_SHARDS;LABEL" "SOURCES;USES;LIBS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  list(TRANSFORM ARG_USES PREPEND sinew::)
  set(libraries ${ARG_USES} ${ARG_LIBS} GTest::gmock GTest::gtest_main)
  if(TARGET sinew_trap)
    list(APPEND libraries sinew_trap)
  endif()
  sinew_test_optimised(${name} optimised)

  add_library(${name}_object OBJECT EXCLUDE_FROM_ALL ${ARG_SOURCES})  # objects are -fPIC, as their precompiled header
  sinew_test_options(${name}_object ${optimised})
  target_link_libraries(${name}_object PRIVATE ${libraries})
  add_executable(${name})
  set_target_properties(${name} PROPERTIES LINKER_LANGUAGE CXX)
  target_link_libraries(${name} PRIVATE ${name}_object ${libraries} ${SINEW_OF_EVERY_TEST})
  target_link_options(${name} PRIVATE ${SINEW_FAST_LINK})
  if(ARG_ALONE OR CMAKE_CROSSCOMPILING)
    sinew_test_cases(${name} ${ARG_TIMEOUT} "${ARG_EMULATED_SHARDS}" ${ARG_LABEL})
    return()
  endif()
  set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)

  get_property(begun DIRECTORY PROPERTY SINEW_TEST_LIBRARIES)
  if(NOT begun)
    cmake_language(DEFER CALL sinew_test_program)
  endif()
  get_property(known DIRECTORY PROPERTY SINEW_TEST_SOURCES)  # a source of several tests is in their program once
  list(REMOVE_ITEM ARG_SOURCES ${known})
  set_property(DIRECTORY APPEND PROPERTY SINEW_TEST_SOURCES ${ARG_SOURCES})
  if(optimised)
    set_property(DIRECTORY APPEND PROPERTY SINEW_TEST_OPTIMISED ${ARG_SOURCES})
  endif()
  set_property(DIRECTORY APPEND PROPERTY SINEW_TEST_LIBRARIES ${libraries})
  get_property(longest DIRECTORY PROPERTY SINEW_TEST_TIMEOUT)
  if(NOT longest OR ARG_TIMEOUT GREATER longest)
    set_property(DIRECTORY PROPERTY SINEW_TEST_TIMEOUT ${ARG_TIMEOUT})
  endif()
endfunction()

# The program of all tests of this folder that are not ALONE.
function(sinew_test_program)
  file(RELATIVE_PATH program ${PROJECT_SOURCE_DIR}/tests ${CMAKE_CURRENT_SOURCE_DIR})
  string(REPLACE / _ program ${program}_tests)
  get_property(plain DIRECTORY PROPERTY SINEW_TEST_SOURCES)
  get_property(optimised DIRECTORY PROPERTY SINEW_TEST_OPTIMISED)
  get_property(libraries DIRECTORY PROPERTY SINEW_TEST_LIBRARIES)
  get_property(timeout DIRECTORY PROPERTY SINEW_TEST_TIMEOUT)
  list(REMOVE_DUPLICATES libraries)
  list(REMOVE_ITEM plain ${optimised})
  add_executable(${program})
  set_target_properties(${program} PROPERTIES LINKER_LANGUAGE CXX)
  target_link_libraries(${program} PRIVATE ${libraries} ${SINEW_OF_EVERY_TEST})
  target_link_options(${program} PRIVATE ${SINEW_FAST_LINK})
  foreach(part plain optimised)
    if(${part})
      string(COMPARE EQUAL ${part} optimised is_optimised)
      add_library(${program}_${part} OBJECT ${${part}})
      target_link_libraries(${program}_${part} PRIVATE ${libraries})
      sinew_test_options(${program}_${part} ${is_optimised})
      sinew_batches(${program}_${part} 8)
      target_link_libraries(${program} PRIVATE ${program}_${part})
    endif()
  endforeach()
  sinew_test_cases(${program} ${timeout} "")
endfunction()

# Most tests calculate little themselves: compiling them without optimisation saves a fifth of the time, half for rt.
# Tests of rt's lock-free headers are optimised, as in robots, and so are tests that fly in a world of their own.
function(sinew_test_optimised name result)
  set(${result} ON PARENT_SCOPE)
  if(NOT CMAKE_BUILD_TYPE STREQUAL Debug AND
     name MATCHES "^(msg|wire|hal|rt|drivers|tap|client|monitor|record|dataset|sim_hil|apps|search|boards|devices)_" AND
     NOT name MATCHES "^rt_(topic|held_loans|mailbox|instant_word|handover|schedule|stats|fp_mode)" AND
     NOT name MATCHES "^apps_(module_fault|flight_failsafe|pilot_flight|flight_again|sweep_memory)")
    set(${result} OFF PARENT_SCOPE)
  endif()
endfunction()

# How a test is compiled.
function(sinew_test_options target optimised)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests/include)
  set(options "")
  # Undefined behaviour is checked in the rooms, not in GoogleTest's code in a test: that halves the time to compile it.
  if(SINEW_SANITIZE MATCHES undefined AND NOT SINEW_ROOM_IS_HEADERS)
    list(APPEND options -fno-sanitize=undefined)
  endif()
  if(NOT CMAKE_BUILD_TYPE STREQUAL Debug)  # GoogleTest prints their lines; a tenth less to compile
    list(APPEND options -g0)
    if(NOT optimised)
      list(APPEND options -O0)
    endif()
  endif()
  target_compile_options(${target} PRIVATE ${options})
  if(SINEW_PRECOMPILED)
    sinew_precompile(${target} ${PROJECT_SOURCE_DIR}/tests/include/precompiled.hpp GTest::gmock "${options}")
  endif()
endfunction()

# Its cases are tests of ctest, with a label if one is given.
function(sinew_test_cases program timeout emulated_shards)
  set(label "")
  if(ARGN)
    set(label LABELS ${ARGN})
  endif()
  if(NOT CMAKE_CROSSCOMPILING)
    gtest_discover_tests(${program} PROPERTIES TIMEOUT ${timeout} ${label} DISCOVERY_TIMEOUT 60)
    return()
  endif()
  math(EXPR timeout "${timeout} * 5")
  add_test(NAME ${program} COMMAND ${program})
  set_tests_properties(${program} PROPERTIES TIMEOUT ${timeout} SKIP_RETURN_CODE 77 ${label})  # wine32.sh: not run
  if(emulated_shards)  # for hundreds of cases of one kind that take seconds each: one test for each shard
    set_tests_properties(${program} PROPERTIES ENVIRONMENT "GTEST_TOTAL_SHARDS=${emulated_shards};GTEST_SHARD_INDEX=0")
  endif()
endfunction()

# sinew_precompile(TARGET HEADER LIBRARIES OPTIONS): compiles a header that nearly all targets of a kind include once
# for all targets with the same options.
function(sinew_precompile target header libraries options)
  file(RELATIVE_PATH place ${PROJECT_SOURCE_DIR} ${header})
  string(MD5 key "${place} ${options}")  # the same in each clone: the compiler cache sees it in a path
  set(base precompiled_${key})
  if(NOT TARGET ${base})
    file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/precompiled.cpp CONTENT "")
    add_library(${base} OBJECT EXCLUDE_FROM_ALL ${CMAKE_BINARY_DIR}/precompiled.cpp)
    target_link_libraries(${base} PRIVATE ${libraries})
    target_compile_options(${base} PRIVATE ${options} ${SINEW_CACHED_PRECOMPILED})
    target_precompile_headers(${base} PRIVATE ${header})
  endif()
  target_compile_options(${target} PRIVATE ${SINEW_CACHED_PRECOMPILED})
  target_precompile_headers(${target} REUSE_FROM ${base})
endfunction()

# sinew_fuzz(NAME SOURCES ... USES room... CORPUS dir): a parser under fuzz. With SINEW_FUZZ it is a libFuzzer program;
# otherwise, linked with tests/fuzz/replay_main.cpp, it runs the small corpus of the repository as one ctest case.
function(sinew_fuzz name)
  cmake_parse_arguments(ARG "" "CORPUS" "SOURCES;USES;LIBS" ${ARGN})
  get_filename_component(ARG_CORPUS ${ARG_CORPUS} ABSOLUTE)
  if(SINEW_FUZZ)
    add_executable(${name} ${ARG_SOURCES})
    target_compile_options(${name} PRIVATE -fsanitize=fuzzer-no-link)
    target_link_options(${name} PRIVATE -fsanitize=fuzzer)
    add_dependencies(fuzzers ${name})
    file(RELATIVE_PATH program ${CMAKE_BINARY_DIR} ${CMAKE_CURRENT_BINARY_DIR}/${name})
    file(APPEND ${CMAKE_BINARY_DIR}/fuzzers.txt "${program} ${ARG_CORPUS}\n")
  elseif(SINEW_SANITIZE MATCHES thread)
    return()  # one thread: that sanitizer has nothing to find
  else()
    add_executable(${name} ${ARG_SOURCES} ${PROJECT_SOURCE_DIR}/tests/fuzz/replay_main.cpp)
    if(NOT CMAKE_BUILD_TYPE STREQUAL Debug)  # small corpora: compiling takes longer than running
      target_compile_options(${name} PRIVATE -g0 -O0)
    endif()
    add_test(NAME ${name}.Corpus COMMAND ${name} ${ARG_CORPUS})
  endif()
  foreach(room ${ARG_USES})
    target_link_libraries(${name} PRIVATE sinew::${room})
  endforeach()
  target_link_libraries(${name} PRIVATE ${ARG_LIBS})
endfunction()
