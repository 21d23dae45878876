# Functions that declare the project's targets: modules (ugoki_module) and their test programs (ugoki_test).

# Language and warning settings of all code of this project.
add_library(ugoki_settings INTERFACE)
target_compile_features(ugoki_settings INTERFACE cxx_std_23)
target_include_directories(ugoki_settings INTERFACE ${PROJECT_SOURCE_DIR}/src)
target_compile_options(ugoki_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Werror
  -ffp-contract=off                                  # equal floating-point bits on all compilers and machines
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized> # false alarms of g++ 12 at -O3
  $<$<CXX_COMPILER_ID:GNU>:-Wno-dangling-else>       # "if (x) EXPECT_..." of GoogleTest
  $<$<CXX_COMPILER_ID:GNU>:-fPIC> $<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>  # modules are linked into exported FMUs; clang needs no option
)
if(UGOKI_SANITIZE)
  target_compile_options(ugoki_settings INTERFACE -fsanitize=${UGOKI_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(ugoki_settings INTERFACE -fsanitize=${UGOKI_SANITIZE})
endif()

# Parsing the headers of the standard library takes more than a second of processor time, most of the time of a small source, and that of mechanisms
# half a second. With this option they are parsed once for all modules, together with JSON once for the modules that use it, and with GoogleTest once
# for the tests. Sources with compile options of their own have the property SKIP_PRECOMPILE_HEADERS. Builds without the option check that sources
# include all they use.
option(UGOKI_PRECOMPILED_HEADERS "Precompile the headers of the standard library, mechanisms, JSON and GoogleTest" OFF)
set(ugoki_mechanism_header ${PROJECT_SOURCE_DIR}/src/ugoki/mechanism/mechanism.h)
set(ugoki_standard_headers <algorithm> <array> <atomic> <chrono> <cmath> <condition_variable> <cstdint> <cstring> <expected> <filesystem> <fstream> <functional>
  <limits> <map> <memory> <mutex> <numbers> <optional> <ranges> <set> <span> <string> <string_view> <thread> <utility> <variant> <vector>)

# use_precompiled(<target> <kind> LIBS <targets>... HEADERS <headers>... [OPTIONS <options>...]): compiles the headers once for all targets of a kind.
function(use_precompiled target kind)
  cmake_parse_arguments(ARG "" "" "LIBS;HEADERS;OPTIONS" ${ARGN})
  if(NOT UGOKI_PRECOMPILED_HEADERS)
    return()
  endif()
  # A time stamp in the precompiled header would keep compiler caches from finding the results.
  set(no_time_stamp $<$<COMPILE_LANG_AND_ID:CXX,Clang>:SHELL:-Xclang -fno-pch-timestamp>)
  target_compile_options(${target} PRIVATE ${no_time_stamp})
  if(NOT TARGET ugoki_${kind}_headers)
    add_library(ugoki_${kind}_headers OBJECT ${PROJECT_SOURCE_DIR}/cmake/headers.cpp)
    target_link_libraries(ugoki_${kind}_headers PRIVATE ugoki_settings ${ARG_LIBS})
    target_compile_options(ugoki_${kind}_headers PRIVATE ${no_time_stamp} ${ARG_OPTIONS})
    target_precompile_headers(ugoki_${kind}_headers PRIVATE ${ugoki_standard_headers} ${ARG_HEADERS})
  endif()
  target_precompile_headers(${target} REUSE_FROM ugoki_${kind}_headers)
endfunction()

# ugoki_dependencies(<variable> <modules>...): all modules on which these depend, and these.
function(ugoki_dependencies out)
  set(all "")
  foreach(name IN LISTS ARGN)
    get_property(more GLOBAL PROPERTY UGOKI_DEPENDS_${name})
    ugoki_dependencies(deeper ${more})
    list(APPEND all ${name} ${deeper})
  endforeach()
  list(REMOVE_DUPLICATES all)
  set(${out} ${all} PARENT_SCOPE)
endfunction()

# ugoki_module(<name> SOURCES <files>... [DEPENDS <modules>...] [PRIVATE_LIBS <targets>...]): adds the library ugoki_<name>.
function(ugoki_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_LIBS" ${ARGN})
  if(ARG_SOURCES)
    add_library(ugoki_${name} STATIC ${ARG_SOURCES})
    target_link_libraries(ugoki_${name} PUBLIC ugoki_settings PRIVATE ${ARG_PRIVATE_LIBS})
    set(options "")
    set(small "")
    if(name IN_LIST UGOKI_SMALL_MODULES)
      set(options OPTIONS -Oz)
      set(small small_)
      target_compile_options(ugoki_${name} PRIVATE -Oz)
    endif()
    ugoki_dependencies(all ${ARG_DEPENDS})
    set(headers HEADERS)
    set(kind standard)
    if(mechanism IN_LIST all)
      list(APPEND headers ${ugoki_mechanism_header})
      set(kind mechanism)
    endif()
    if(nlohmann_json::nlohmann_json IN_LIST ARG_PRIVATE_LIBS)
      use_precompiled(ugoki_${name} ${small}json_${kind} LIBS nlohmann_json::nlohmann_json ${headers} <nlohmann/json.hpp> ${options})
    else()
      use_precompiled(ugoki_${name} ${small}${kind} ${headers} ${options})
    endif()
    set(visibility PUBLIC)
  else()
    add_library(ugoki_${name} INTERFACE)
    target_link_libraries(ugoki_${name} INTERFACE ugoki_settings)
    set(visibility INTERFACE)
  endif()
  foreach(dep IN LISTS ARG_DEPENDS)
    target_link_libraries(ugoki_${name} ${visibility} ugoki_${dep})
  endforeach()
  set_property(GLOBAL APPEND PROPERTY UGOKI_MODULES ${name})
  set_property(GLOBAL PROPERTY UGOKI_DEPENDS_${name} "${ARG_DEPENDS}")
endfunction()

# ugoki_test(<module> SOURCES <files>... [DEPENDS <modules>...] [LIBS <targets>...] [OPTIMISED]): adds one GoogleTest program for a module.
# OPTIMISED: the tests compute much themselves, such as reference solutions or long random sequences.
function(ugoki_test name)
  cmake_parse_arguments(ARG "OPTIMISED" "" "SOURCES;DEPENDS;LIBS" ${ARGN})
  find_package(GTest REQUIRED)
  find_package(nlohmann_json REQUIRED)
  add_executable(ugoki_${name}_test ${ARG_SOURCES})
  if(TARGET ugoki_${name})
    target_link_libraries(ugoki_${name}_test PRIVATE ugoki_${name})
  endif()
  foreach(dep IN LISTS ARG_DEPENDS)
    target_link_libraries(ugoki_${name}_test PRIVATE ugoki_${dep})
  endforeach()
  target_link_libraries(ugoki_${name}_test PRIVATE ugoki_settings GTest::gtest_main ${ARG_LIBS})
  # In release builds, code of tests is optimised only where it computes much, because unoptimised code compiles in half the time.
  # The floating-point bits are equal (-ffp-contract=off).
  set(kind test)
  set(optimise $<$<CONFIG:Release>:-O0>)
  if(ARG_OPTIMISED)
    set(kind optimised_test)
    set(optimise $<$<CONFIG:Release>:-O1>)
  endif()
  target_compile_options(ugoki_${name}_test PRIVATE ${optimise})
  use_precompiled(ugoki_${name}_test ${kind} LIBS GTest::gtest nlohmann_json::nlohmann_json HEADERS <random> <sstream> <gtest/gtest.h> <nlohmann/json.hpp> ${ugoki_mechanism_header}
    OPTIONS ${optimise})
  target_compile_definitions(ugoki_${name}_test PRIVATE
    UGOKI_SHARED_DATA="${PROJECT_SOURCE_DIR}/../shared/data" UGOKI_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  add_test(NAME ${name} COMMAND ugoki_${name}_test --gtest_filter=-Slow*)
  set_property(GLOBAL APPEND PROPERTY UGOKI_TEST_PROGRAMS ugoki_${name}_test)
endfunction()
