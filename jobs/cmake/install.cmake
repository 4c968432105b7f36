# The manual page and the completions are made from the table that --help prints.
add_executable(stylet_pages src/app/pages.cpp src/app/command_line.cpp)
target_link_libraries(stylet_pages PRIVATE stylet_study CLI11::CLI11)
set(pages ${PROJECT_BINARY_DIR}/pages)
add_custom_command(
  OUTPUT ${pages}/man/stylet.1 ${pages}/bash/stylet ${pages}/zsh/_stylet ${pages}/fish/stylet.fish
  COMMAND ${CMAKE_COMMAND} -E make_directory ${pages}/man ${pages}/bash ${pages}/zsh ${pages}/fish
  COMMAND stylet_pages man > ${pages}/man/stylet.1
  COMMAND stylet_pages bash > ${pages}/bash/stylet
  COMMAND stylet_pages zsh > ${pages}/zsh/_stylet
  COMMAND stylet_pages fish > ${pages}/fish/stylet.fish
  DEPENDS stylet_pages VERBATIM)
add_custom_target(pages ALL DEPENDS ${pages}/man/stylet.1)

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME program)
install(TARGETS stylet)
install(FILES ${pages}/man/stylet.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${pages}/bash/stylet DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${pages}/zsh/_stylet DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${pages}/fish/stylet.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)
install(FILES input/prostate.yaml input/prostate.accuracy.json input/block.yaml DESTINATION ${data}/input)
install(DIRECTORY input/campaigns DESTINATION ${data}/input FILES_MATCHING PATTERN *.yaml
        PATTERN pictures EXCLUDE)
install(FILES meshes/prostate.geo meshes/prostate.msh DESTINATION ${data}/meshes)
# All scripts but those that need the source tree.
install(DIRECTORY jobs DESTINATION ${data} USE_SOURCE_PERMISSIONS FILES_MATCHING PATTERN *.py
        PATTERN bench.py EXCLUDE PATTERN peers.py EXCLUDE
        PATTERN profile.py EXCLUDE PATTERN window_speed.py EXCLUDE PATTERN slurm EXCLUDE PATTERN cmake EXCLUDE
        PATTERN __pycache__ EXCLUDE)

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME development)
include(CMakePackageConfigHelpers)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/styletConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
set(config ${CMAKE_INSTALL_LIBDIR}/cmake/stylet)
install(EXPORT styletTargets NAMESPACE stylet:: DESTINATION ${config})
install(FILES jobs/cmake/styletConfig.cmake jobs/cmake/dependencies.cmake
        ${PROJECT_BINARY_DIR}/styletConfigVersion.cmake DESTINATION ${config})
install(DIRECTORY include/stylet DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} PATTERN app EXCLUDE
        PATTERN view EXCLUDE)
