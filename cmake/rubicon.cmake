# One folder = one library. rubicon_library(tuples LINKS rubicon_model) takes all sources of the folder it stands in.

find_program(RUBICON_CCACHE ccache)
if(RUBICON_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${RUBICON_CCACHE})
endif()

# Links in a third of the time of GNU ld.
find_program(RUBICON_LLD ld.lld)
if(RUBICON_LLD)
  add_link_options(-fuse-ld=lld)
endif()

# Compiles the files of a target in batches of twelve: most of the time is spent in the headers of libraries, not in our
# own lines. OFF compiles each file separately, which clang-tidy and the check for missing includes need.
option(RUBICON_UNITY "Compile files of a target in batches" ON)
if(RUBICON_UNITY)
  set(CMAKE_UNITY_BUILD ON)
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 12)
endif()

option(RUBICON_WERROR "Treat compiler warnings as errors" ON)

add_library(rubicon_options INTERFACE)
target_include_directories(rubicon_options INTERFACE ${CMAKE_SOURCE_DIR}/src ${CMAKE_SOURCE_DIR}/include)
target_compile_definitions(rubicon_options INTERFACE RUBICON_VERSION="${PROJECT_VERSION}")
target_compile_options(rubicon_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion $<$<BOOL:${RUBICON_WERROR}>:-Werror>
  $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor> $<$<COMPILE_LANGUAGE:CXX>:-Woverloaded-virtual>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Nobody replaces our functions at run time: g++ may then inline in position independent code as clang does anyway.
  target_compile_options(rubicon_options INTERFACE -fno-semantic-interposition)
  if(RUBICON_UNITY)
    # g++ takes each .cpp of a batch for a header, and names of one file are visible in the next.
    target_compile_options(rubicon_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-subobject-linkage> -Wno-shadow -Wshadow=local)
  endif()
  # g++ 12 reports overflows that are not there in inlined std::vector<uint8_t> and std::string code at -O2.
  target_compile_options(rubicon_options INTERFACE
    -Wno-error=stringop-overflow -Wno-error=array-bounds -Wno-error=restrict -Wno-error=maybe-uninitialized)
endif()
if(RUBICON_UNITY AND CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  target_compile_options(rubicon_options INTERFACE -Wno-shadow)  # clang has no -Wshadow=local
endif()
if(RUBICON_SANITIZE)
  target_compile_options(rubicon_options INTERFACE -fsanitize=${RUBICON_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(rubicon_options INTERFACE -fsanitize=${RUBICON_SANITIZE})
  if(RUBICON_SANITIZE MATCHES "thread" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(rubicon_options INTERFACE -Wno-tsan)  # fences in Boost.Asio: g++ says that it does not see them
  endif()
  if(RUBICON_SANITIZE MATCHES "undefined")
    target_compile_options(rubicon_options INTERFACE -fno-sanitize-recover=undefined)
  endif()
endif()
if(RUBICON_FUZZ)
  target_compile_options(rubicon_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

function(rubicon_library name)
  cmake_parse_arguments(ARG "" "TARGET" "LINKS;EXCLUDE;EXCLUDE_FILES" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cpp)
  foreach(file ${ARG_EXCLUDE_FILES})
    list(FILTER sources EXCLUDE REGEX "/${name}/${file}\\.cpp$")
  endforeach()
  foreach(folder ${ARG_EXCLUDE})
    list(FILTER sources EXCLUDE REGEX "/${name}/${folder}/")
  endforeach()
  string(REPLACE "/" "_" target rubicon_${name})
  if(ARG_TARGET)
    set(target ${ARG_TARGET})
  endif()
  if(NOT sources)
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE rubicon_options ${ARG_LINKS})
    return()
  endif()
  add_library(${target} STATIC ${sources})
  target_link_libraries(${target} PUBLIC rubicon_options ${ARG_LINKS})
endfunction()

# For what runs once or seldom: -O2 would cost a third more time to compile in the build of ./run.
function(rubicon_quick_to_compile)
  foreach(target ${ARGN})
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endforeach()
endfunction()

# A network plug-in: src/networks/<name>, with its sample.yaml compiled in as kSample (<name>_sample.h). It is part of
# rubicon-proxy, unless it lies in another FOLDER.
function(rubicon_network name)
  cmake_parse_arguments(ARG "" "FOLDER;NAMESPACE" "LINKS" ${ARGN})
  if(NOT ARG_FOLDER)
    set_property(GLOBAL APPEND PROPERTY RUBICON_NETWORKS ${name})
  endif()
  if(TARGET rubicon_networks_${name})
    return()  # taken from another build: tests/contract/new_network
  endif()
  if(NOT ARG_NAMESPACE)
    set(ARG_NAMESPACE ${name})
  endif()
  if(ARG_FOLDER)
    set(elsewhere ${ARG_FOLDER}/..)
  else()
    set(ARG_FOLDER ${CMAKE_CURRENT_SOURCE_DIR}/networks/${name})
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${ARG_FOLDER}/*.cpp)
  if(NOT sources)
    add_library(rubicon_networks_${name} INTERFACE)
    return()
  endif()
  set(header ${CMAKE_BINARY_DIR}/generated/networks/${name}/${name}_sample.h)
  file(READ ${ARG_FOLDER}/sample.yaml sample)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${ARG_FOLDER}/sample.yaml)
  file(CONFIGURE OUTPUT ${header} CONTENT
"#pragma once
#include <string_view>
namespace rubicon::networks::${ARG_NAMESPACE} {
inline constexpr std::string_view kSample = R\"sample(${sample})sample\";
}
" @ONLY)
  add_library(rubicon_networks_${name} STATIC ${sources})
  target_include_directories(rubicon_networks_${name} PUBLIC ${CMAKE_BINARY_DIR}/generated ${elsewhere})
  target_link_libraries(rubicon_networks_${name} PUBLIC rubicon_network ${ARG_LINKS})
endfunction()

# rubicon_all_networks: all networks of rubicon-proxy, and networks/all_networks.h with their types.
function(rubicon_all_networks)
  get_property(networks GLOBAL PROPERTY RUBICON_NETWORKS)
  add_library(rubicon_all_networks INTERFACE)
  set(includes "")
  set(types "")
  foreach(name ${networks})
    string(APPEND includes "#include \"networks/${name}/${name}_network.h\"\n")
    string(APPEND types "    rubicon::networks::${name}::kType,\n")
    target_link_libraries(rubicon_all_networks INTERFACE rubicon_networks_${name})
  endforeach()
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/networks/all_networks.h CONTENT
"#pragma once
#include <array>
${includes}
namespace rubicon::networks {
inline auto all_types() {
  return std::array{
${types}  };
}
}
" @ONLY)
endfunction()

# The files of a folder of apps/ but its main.cpp, as a library rubicon_<folder> (or TARGET).
function(rubicon_program_parts folder)
  cmake_parse_arguments(ARG "" "TARGET" "LINKS" ${ARGN})
  if(NOT ARG_TARGET)
    set(ARG_TARGET rubicon_${folder})
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/main.cpp$")
  add_library(${ARG_TARGET} STATIC ${sources})
  target_include_directories(${ARG_TARGET} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(${ARG_TARGET} PUBLIC ${ARG_LINKS})
endfunction()

# tests/<folder>/*.cpp, and those of its sub-folders ROOMS -> <folder>_test. COST: its seconds on a quiet machine, so that the longest begin first.
function(rubicon_test folder)
  cmake_parse_arguments(ARG "" "TIMEOUT;COST" "LINKS;ROOMS" ${ARGN})
  set(patterns ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  foreach(room ${ARG_ROOMS})
    list(APPEND patterns ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/${room}/*.cpp)
  endforeach()
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  string(REPLACE "/" "_" target ${folder}_test)
  add_executable(${target} ${sources})
  target_include_directories(${target} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_compile_definitions(${target} PRIVATE
    RUBICON_SOURCE_DIR="${CMAKE_SOURCE_DIR}" RUBICON_BINARY_DIR="${CMAKE_BINARY_DIR}")
  target_link_libraries(${target} PRIVATE ${ARG_LINKS} rubicon_test_support GTest::gtest_main)
  add_test(NAME ${target} COMMAND ${target} --gtest_brief=1)
  set_tests_properties(${target} PROPERTIES TIMEOUT ${ARG_TIMEOUT} ENVIRONMENT RUBICON_TRUST=no)  # whatever this host has
  if(ARG_COST)
    set_tests_properties(${target} PROPERTIES COST ${ARG_COST})
  endif()
endfunction()

# The files of a folder as a part of the target: rubicon::web::files::embedded_files().
function(rubicon_embedded_page target folder)
  file(GLOB files CONFIGURE_DEPENDS ${folder}/*)
  set(source ${CMAKE_BINARY_DIR}/generated/web/page.cpp)
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/generated/web)
  add_custom_command(OUTPUT ${source}
    COMMAND ${CMAKE_COMMAND} "-DFILES=${files}" -DOUTPUT=${source} -P ${CMAKE_SOURCE_DIR}/cmake/embed_page.cmake
    DEPENDS ${files} ${CMAKE_SOURCE_DIR}/cmake/embed_page.cmake COMMENT "Embedding the page" VERBATIM)
  target_sources(${target} PRIVATE ${source})
  set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
