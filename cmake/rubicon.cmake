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

# The compiler sees blocks (rubicon_block): most of its time goes into headers and templates, which each file would repeat.
# OFF compiles each file separately, which clang-tidy and the check for missing includes need.
option(RUBICON_UNITY "Compile rooms in blocks, and the files of other targets in batches" ON)
if(RUBICON_UNITY)
  set(CMAKE_UNITY_BUILD ON)
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 24)
endif()
include(${CMAKE_CURRENT_LIST_DIR}/alone.cmake)

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
# g++ collects its garbage whenever its heap has doubled, a tenth of the time of a block. Where each processor has 4 GB, it need not.
cmake_host_system_information(RESULT processors QUERY NUMBER_OF_LOGICAL_CORES)
cmake_host_system_information(RESULT megabytes QUERY TOTAL_PHYSICAL_MEMORY)
math(EXPR megabytes_each "${megabytes} / ${processors}")
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND megabytes_each GREATER_EQUAL 4000)
  target_compile_options(rubicon_options INTERFACE "SHELL:--param ggc-min-heapsize=1500000")
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

# rubicon_block(space): rooms with BLOCK space are compiled as one file. A block may need only blocks that were declared before it.
function(rubicon_block name)
  if(NOT RUBICON_UNITY)
    return()
  endif()
  add_library(rubicon_block_${name} STATIC)
  set_target_properties(rubicon_block_${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 0)
  target_link_libraries(rubicon_block_${name} PUBLIC rubicon_options)
endfunction()

# rubicon_room(TARGET [BLOCK space] SOURCES ... LINKS ... PRIVATE_LINKS ... INCLUDES ... DEFINES ...): a library of these files. With a
# block, the files are the block's, and who links the room links the block.
function(rubicon_room target)
  cmake_parse_arguments(ARG "" "BLOCK" "SOURCES;LINKS;PRIVATE_LINKS;INCLUDES;DEFINES" ${ARGN})
  if(NOT ARG_BLOCK OR NOT RUBICON_UNITY)
    add_library(${target} STATIC ${ARG_SOURCES})
    target_include_directories(${target} PUBLIC ${ARG_INCLUDES})
    target_compile_definitions(${target} PRIVATE ${ARG_DEFINES})
    target_link_libraries(${target} PUBLIC rubicon_options ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS})
    rubicon_compile_changed_alone(${target})
    return()
  endif()
  set(block rubicon_block_${ARG_BLOCK})
  target_sources(${block} PRIVATE ${ARG_SOURCES})
  target_include_directories(${block} PUBLIC ${ARG_INCLUDES})
  target_compile_definitions(${block} PRIVATE ${ARG_DEFINES})
  target_link_libraries(${block} PRIVATE ${ARG_PRIVATE_LINKS})
  foreach(link ${ARG_LINKS})
    if(TARGET ${link})
      get_target_property(in ${link} RUBICON_BLOCK)
      if(in STREQUAL block)
        continue()
      endif()
    endif()
    target_link_libraries(${block} PUBLIC ${link})
  endforeach()
  add_library(${target} INTERFACE)
  set_target_properties(${target} PROPERTIES RUBICON_BLOCK ${block})
  target_link_libraries(${target} INTERFACE ${block})
  rubicon_compile_changed_alone(${block})
endfunction()

# The room of a folder of src/: its sources and those of the folders below.
function(rubicon_library name)
  cmake_parse_arguments(ARG "" "TARGET;BLOCK" "LINKS;PRIVATE_LINKS;DEFINES;EXCLUDE;EXCLUDE_FILES" ${ARGN})
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
  rubicon_room(${target} BLOCK ${ARG_BLOCK} SOURCES ${sources} LINKS ${ARG_LINKS} PRIVATE_LINKS ${ARG_PRIVATE_LINKS}
               DEFINES ${ARG_DEFINES})
endfunction()

# A network plug-in: src/networks/<name>, with its sample.yaml compiled in as kSample (<name>_sample.h). It is part of
# rubicon-proxy, unless it lies in another FOLDER.
function(rubicon_network name)
  cmake_parse_arguments(ARG "" "FOLDER;NAMESPACE;BLOCK" "LINKS" ${ARGN})
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
  rubicon_room(rubicon_networks_${name} BLOCK ${ARG_BLOCK} SOURCES ${sources} LINKS rubicon_network ${ARG_LINKS}
               INCLUDES ${CMAKE_BINARY_DIR}/generated ${elsewhere})
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
  cmake_parse_arguments(ARG "" "TARGET;BLOCK" "LINKS" ${ARGN})
  if(NOT ARG_TARGET)
    set(ARG_TARGET rubicon_${folder})
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/main.cpp$")
  rubicon_room(${ARG_TARGET} BLOCK ${ARG_BLOCK} SOURCES ${sources} LINKS ${ARG_LINKS} INCLUDES ${CMAKE_SOURCE_DIR})
endfunction()

# tests/<folder>/*.cpp but EXCEPT -> <folder>_test. FOLDERS: of these folders instead, and <folder> is only the name. COST: its seconds
# on a quiet machine, so that the longest begin first. SHARDS: how many parts of it may run at the same time.
function(rubicon_test folder)
  cmake_parse_arguments(ARG "" "TIMEOUT;COST;SHARDS" "LINKS;FOLDERS;EXCEPT" ${ARGN})
  if(NOT ARG_FOLDERS)
    set(ARG_FOLDERS ${folder})
  endif()
  list(TRANSFORM ARG_FOLDERS REPLACE "(.+)" "${CMAKE_CURRENT_SOURCE_DIR}/\\1/*.cpp" OUTPUT_VARIABLE patterns)
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  list(REMOVE_ITEM sources "" ${ARG_EXCEPT})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 900)
  endif()
  string(REPLACE "/" "_" target ${folder}_test)
  add_executable(${target} ${sources} ${CMAKE_SOURCE_DIR}/tests/support/every_program/own_folder.cpp)
  target_include_directories(${target} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_compile_definitions(${target} PRIVATE
    RUBICON_SOURCE_DIR="${CMAKE_SOURCE_DIR}" RUBICON_BINARY_DIR="${CMAKE_BINARY_DIR}")
  target_link_libraries(${target} PRIVATE ${ARG_LINKS} rubicon_test_support GTest::gtest_main)
  rubicon_compile_changed_alone(${target})
  set(shards 1)
  if(ARG_SHARDS)
    set(shards ${ARG_SHARDS})
  endif()
  foreach(shard RANGE 1 ${shards})
    set(name ${target})
    if(shards GREATER 1)
      set(name ${target}_${shard})
    endif()
    math(EXPR index "${shard} - 1")
    add_test(NAME ${name} COMMAND ${target} --gtest_brief=1 --gtest_output=json:${CMAKE_BINARY_DIR}/results/${name}.json)
    set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT}
      ENVIRONMENT "RUBICON_TRUST=no;GTEST_TOTAL_SHARDS=${shards};GTEST_SHARD_INDEX=${index}")  # trust: whatever this host has
    if(ARG_COST)
      set_tests_properties(${name} PROPERTIES COST ${ARG_COST})
    endif()
  endforeach()
endfunction()

# The files of a folder as a part of the target: rubicon::web::files::embedded_files().
function(rubicon_embedded_page target folder)
  get_target_property(block ${target} RUBICON_BLOCK)
  if(block)
    set(target ${block})
  endif()
  file(GLOB files CONFIGURE_DEPENDS ${folder}/*)
  set(source ${CMAKE_BINARY_DIR}/generated/web/page.cpp)
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/generated/web)
  add_custom_command(OUTPUT ${source}
    COMMAND ${CMAKE_COMMAND} "-DFILES=${files}" -DOUTPUT=${source} -P ${CMAKE_SOURCE_DIR}/cmake/embed_page.cmake
    DEPENDS ${files} ${CMAKE_SOURCE_DIR}/cmake/embed_page.cmake COMMENT "Embedding the page" VERBATIM)
  target_sources(${target} PRIVATE ${source})
  set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
