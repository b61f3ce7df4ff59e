# SPDX-License-Identifier: Apache-2.0
# cmake -DPROGRAM=fringetwin -DOUT=folder -P manual.cmake: writes the manual pages (man1/*.1.gz) and the completions of
# bash, zsh and fish that the program prints of itself.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${OUT})
file(MAKE_DIRECTORY ${OUT}/man1)
function(print_to file)
  execute_process(COMMAND ${PROGRAM} ${ARGN} OUTPUT_FILE ${OUT}/${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

execute_process(COMMAND ${PROGRAM} man --list OUTPUT_VARIABLE pages OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "\n" ";" pages "${pages}")
foreach(page ${pages}) # "fringetwin-import-opencv.1 import opencv"
  string(REPLACE " " ";" words "${page}")
  list(POP_FRONT words file)
  print_to(man1/${file} man ${words})
  execute_process(COMMAND gzip -9nf ${OUT}/man1/${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
print_to(fringetwin completions bash)
print_to(_fringetwin completions zsh)
print_to(fringetwin.fish completions fish)
