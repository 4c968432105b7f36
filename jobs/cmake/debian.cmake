# What Debian's policy asks of each package beside its files, made by cpack where they wait to be packed:
# changelog and copyright, the manual page compressed, binaries stripped as dh_strip does it.
set(CMAKE_EXECUTE_PROCESS_COMMAND_ERROR_IS_FATAL ANY)
set(here ${CMAKE_CURRENT_LIST_DIR})

if(NOT CPACK_PACKAGE_CONTACT)
  message(FATAL_ERROR "A package needs a maintainer: set DEBFULLNAME and DEBEMAIL and configure again")
endif()
set(maintainer ${CPACK_PACKAGE_CONTACT})

# Indented as the format wants it, with a point for an empty line.
file(READ ${here}/../../LICENSE license)
string(REGEX MATCH "Copyright \\(c\\) ([^\n]*)" _ "${license}")
set(holder ${CMAKE_MATCH_1})
string(REGEX REPLACE "^.*Copyright[^\n]*\n\n" "" license "${license}")
string(STRIP "${license}" license)
string(REGEX REPLACE "\n\n" "\n.\n" license "${license}")
string(REPLACE "\n" "\n " license " ${license}")

foreach(pair program:stylet development:libstylet-dev)
  string(REPLACE ":" ";" pair ${pair})
  list(GET pair 0 component)
  list(GET pair 1 package)
  set(share ${CPACK_TEMPORARY_DIRECTORY}/${component}/usr/share)
  set(doc ${share}/doc/${package})
  configure_file(${here}/changelog ${doc}/changelog @ONLY)
  execute_process(COMMAND gzip -9nf ${doc}/changelog)
  file(WRITE ${doc}/copyright
"Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: stylet
Comment: A built program links CHOLMOD, whose supernodal module is under the
 GNU General Public License, version 2 or later, and is bound by it:
 /usr/share/common-licenses/GPL-2.

Files: *
Copyright: ${holder}
License: Expat
${license}
")
endforeach()
execute_process(COMMAND gzip -9nf ${CPACK_TEMPORARY_DIRECTORY}/program/usr/share/man/man1/stylet.1)
execute_process(COMMAND strip --strip-unneeded --remove-section=.comment --remove-section=.note
                        ${CPACK_TEMPORARY_DIRECTORY}/program/usr/bin/stylet)
file(GLOB_RECURSE archives ${CPACK_TEMPORARY_DIRECTORY}/development/usr/lib/*.a)
execute_process(COMMAND strip --strip-debug --remove-section=.comment --remove-section=.note
                        --enable-deterministic-archives ${archives})
