# RUBICON_ALONE: source files that git shows as changed are compiled by themselves, so that the next change of one does not compile
# its block again. Each build looks, in some milliseconds, and configures again when the list gets longer. A file stays on the list,
# alone.txt in the build folder: leaving it, for example after a commit, would compile its block once more.
option(RUBICON_ALONE "Compile files that git shows as changed by themselves" OFF)
set(RUBICON_ALONE_FILES "")
find_program(RUBICON_GIT git)
if(RUBICON_ALONE AND RUBICON_UNITY AND RUBICON_GIT AND EXISTS ${CMAKE_SOURCE_DIR}/.git)
  set(look ${CMAKE_COMMAND} -DGIT=${RUBICON_GIT} -DTREE=${CMAKE_SOURCE_DIR} -DLIST=${CMAKE_BINARY_DIR}/alone.txt
    -P ${CMAKE_CURRENT_LIST_DIR}/find_changed.cmake)
  execute_process(COMMAND ${look})
  file(STRINGS ${CMAKE_BINARY_DIR}/alone.txt RUBICON_ALONE_FILES)
  # The output is never made, so the command runs in each build; it writes the list only where that changes.
  add_custom_command(OUTPUT ${CMAKE_BINARY_DIR}/alone.always BYPRODUCTS ${CMAKE_BINARY_DIR}/alone.txt COMMAND ${look}
    COMMENT "Looking for changed files" VERBATIM)
  set_source_files_properties(${CMAKE_BINARY_DIR}/alone.always PROPERTIES SYMBOLIC ON)
  add_custom_target(rubicon_changed_files DEPENDS ${CMAKE_BINARY_DIR}/alone.always)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_BINARY_DIR}/alone.txt)
endif()

function(rubicon_compile_changed_alone target)
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    if(source IN_LIST RUBICON_ALONE_FILES)
      set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
endfunction()
