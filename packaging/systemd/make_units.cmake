# At the time of the installation: the units with the paths that they will have. /usr and /usr/local read /etc, as all
# services do; another prefix has its own.
if(CMAKE_INSTALL_PREFIX MATCHES "^/usr(/local)?/?$")
  set(sysconf /etc)
else()
  set(sysconf ${CMAKE_INSTALL_PREFIX}/etc)
endif()
if(NOT IS_ABSOLUTE "${bin}")
  set(bin ${CMAKE_INSTALL_PREFIX}/${bin})
endif()
foreach(unit rubicon-proxy@.service rubicon-broker@.service)
  configure_file(${units_from}/${unit}.in ${units_to}/${unit} @ONLY)
endforeach()
