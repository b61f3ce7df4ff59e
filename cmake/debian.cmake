# SPDX-License-Identifier: Apache-2.0
# CPack runs this once on what it has installed, a folder for each package: adds the files that Debian's policy wants, at its
# paths. The licence's text is part of every Debian. The date is that of the commit, so that the same sources make the same
# packages.
set(when "")
if(EXISTS ${CPACK_FRINGETWIN_SOURCE}/.git)
  execute_process(COMMAND git log -1 --format=%cD WORKING_DIRECTORY ${CPACK_FRINGETWIN_SOURCE}
    OUTPUT_VARIABLE when OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(when STREQUAL "")
  execute_process(COMMAND date -R OUTPUT_VARIABLE when OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
endif()
string(REGEX MATCH "[0-9][0-9][0-9][0-9]" year "${when}")
file(REMOVE ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/program/usr/share/doc/fringetwin/LICENSE)

foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  set(folder ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component}/usr)
  set(documents ${folder}/share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  file(WRITE ${documents}/copyright "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: fringetwin
Upstream-Contact: ${CPACK_PACKAGE_CONTACT}

Files: *
Copyright: ${year} the fringetwin authors
License: Apache-2.0
 On Debian systems, the text of the Apache License, version 2.0, is in
 /usr/share/common-licenses/Apache-2.0.
")
  file(WRITE ${documents}/changelog "fringetwin (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium

  * What has changed is in CHANGELOG.md.

 -- ${CPACK_PACKAGE_CONTACT}  ${when}
")
  execute_process(COMMAND gzip -9nf ${documents}/changelog COMMAND_ERROR_IS_FATAL ANY)
  # CPack strips programs and modules only.
  file(GLOB libraries ${folder}/lib/*.a)
  if(libraries)
    execute_process(COMMAND strip --strip-debug --remove-section=.comment --remove-section=.note --enable-deterministic-archives
      ${libraries} COMMAND_ERROR_IS_FATAL ANY)
  endif()
endforeach()
