# SPDX-License-Identifier: Apache-2.0
# What `cmake --install build --prefix P` puts where. Nothing of it names its place: the program finds modules and data sets
# from where it lies (twin/base/module_loader.hpp), so that the whole may be moved.
#   bin/fringetwin                 the program; shaders are in it
#   lib/fringetwin/modules         windows, GenICam cameras (where Aravis was there), TIFF; directly in lib/fringetwin they would
#                                  make CPack call ldconfig, for which they are nothing
#   share/fringetwin               data sets and the demo
#   share/doc/fringetwin           README, documents, licence
#   share/man/man1                 a page of each command
#   share/bash-completion ...      what shells complete command lines with
# All of it is the component "program"; "python" (python/CMakeLists.txt) and "development" (development.cmake) are beside it.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME program)
set(CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(data share/fringetwin)
set(documents share/doc/fringetwin)
set(module_permissions OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)

set(modules fringetwin_image_codecs fringetwin_window)
if(TARGET fringetwin_genicam) # Aravis was there
  list(APPEND modules fringetwin_genicam)
endif()
install(TARGETS fringetwin_binary RUNTIME DESTINATION bin)
install(TARGETS ${modules} LIBRARY DESTINATION lib/fringetwin/modules PERMISSIONS ${module_permissions})
set_target_properties(${modules} PROPERTIES NO_SONAME ON) # nobody links to them, so no ldconfig has to know them
install(DIRECTORY ${CMAKE_SOURCE_DIR}/datasets DESTINATION ${data} PATTERN "__pycache__" EXCLUDE PATTERN "*.py" EXCLUDE)
install(PROGRAMS scripts/demo.sh DESTINATION ${data})
install(FILES README.md CHANGELOG.md CONTRIBUTING.md LICENSE DESTINATION ${documents})
install(DIRECTORY docs DESTINATION ${documents})
# The documents link to the data sets as in the sources.
install(CODE "file(CREATE_LINK ../../fringetwin/datasets \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${documents}/datasets\" SYMBOLIC)
  list(APPEND CMAKE_INSTALL_MANIFEST_FILES \"\${CMAKE_INSTALL_PREFIX}/${documents}/datasets\")")
# The program that is installed writes its own pages, so that they are those of its commands.
set(manual ${CMAKE_BINARY_DIR}/manual)
install(CODE "execute_process(COMMAND ${CMAKE_COMMAND} -DPROGRAM=${CMAKE_BINARY_DIR}/fringetwin -DOUT=${manual}
  -P ${CMAKE_SOURCE_DIR}/cmake/manual.cmake COMMAND_ERROR_IS_FATAL ANY)")
install(DIRECTORY ${manual}/man1 DESTINATION share/man)
install(FILES ${manual}/fringetwin DESTINATION share/bash-completion/completions)
install(FILES ${manual}/_fringetwin DESTINATION share/zsh/vendor-completions)
install(FILES ${manual}/fringetwin.fish DESTINATION share/fish/vendor_completions.d)
