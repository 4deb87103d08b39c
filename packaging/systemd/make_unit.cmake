# At the time of the installation: the unit with the paths that it will have. /usr and /usr/local read /etc, as all
# services do; another prefix has its own.
if(CMAKE_INSTALL_PREFIX MATCHES "^/usr(/local)?/?$")
  set(sysconf /etc)
else()
  set(sysconf ${CMAKE_INSTALL_PREFIX}/etc)
endif()
if(NOT IS_ABSOLUTE "${bin}")
  set(bin ${CMAKE_INSTALL_PREFIX}/${bin})
endif()
configure_file(${unit_from} ${unit_to} @ONLY)
