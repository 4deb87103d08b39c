# RUBICON_COMMIT: which commit is built, as `git describe` names it; -dirty if tracked files differ from it. Archives of
# `git archive` have the commit, its time and its last tag in commit.txt. Empty where neither is there.
set(RUBICON_COMMIT "")
find_program(RUBICON_GIT git)
if(RUBICON_GIT AND EXISTS ${CMAKE_SOURCE_DIR}/.git)
  execute_process(COMMAND ${RUBICON_GIT} -c safe.directory=${CMAKE_SOURCE_DIR} describe --always --dirty --abbrev=12
    WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE RUBICON_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT RUBICON_COMMIT)
  file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/commit.txt RUBICON_COMMIT LIMIT_COUNT 1)
  if(RUBICON_COMMIT MATCHES "^([0-9a-f]+) ")
    string(SUBSTRING ${CMAKE_MATCH_1} 0 12 RUBICON_COMMIT)
  else()
    set(RUBICON_COMMIT "")
  endif()
endif()
