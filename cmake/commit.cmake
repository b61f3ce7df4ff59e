# SPDX-License-Identifier: Apache-2.0
# cmake -DSOURCE=folder -DHEADER=file -P commit.cmake: writes the commit of a checkout into a header, which is touched
# only where it has changed. Sources without a checkout have none.
cmake_minimum_required(VERSION 3.25)
set(commit "")
if(EXISTS ${SOURCE}/.git) # not the checkout of somebody else around it
  execute_process(COMMAND git describe --always --dirty --exclude=* --abbrev=12 WORKING_DIRECTORY ${SOURCE}
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    set(commit "")
  endif()
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT "#define FRINGETWIN_COMMIT \"@commit@\"\n" @ONLY)
