# `cmake --install build --prefix DIR` gives a tree that can be moved: the program finds its plug-in folder from its own
# place, the package finds the headers from its own. Always lib/, never a multi-arch folder, for the same reason.
include(CMakePackageConfigHelpers)

function(kinora_install)
  install(TARGETS kinora kinora-procedural RUNTIME DESTINATION bin)
  # found by the programs and by each other from where they lie: the tree can be moved
  install(TARGETS kinora_base kinora_image kinora_pictures LIBRARY DESTINATION lib/kinora)
  set_target_properties(kinora kinora-procedural kinora-check-plugin PROPERTIES INSTALL_RPATH "$ORIGIN/../lib/kinora")
  set_target_properties(kinora_base kinora_image kinora_pictures PROPERTIES INSTALL_RPATH "$ORIGIN")
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/kinora DESTINATION include FILES_MATCHING PATTERN "*.h")
  # a place for plug-ins of the user; the stock ones are linked into the program
  install(DIRECTORY DESTINATION lib/kinora/plugins)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/scenes DESTINATION share/kinora)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION share/kinora)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md DESTINATION share/kinora)
  # The testing kit with what it calls of lower floors, so that an author links one archive. kinora-check-plugin, its
  # program, is installed where it is made.
  add_library(kinora_testing_kit STATIC $<TARGET_OBJECTS:kinora_testing> $<TARGET_OBJECTS:kinora_simd>)
  set_target_properties(kinora_testing_kit PROPERTIES OUTPUT_NAME kinora-testing LINKER_LANGUAGE CXX)
  install(TARGETS kinora_testing_kit ARCHIVE DESTINATION lib)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/KinoraConfig.cmake.in ${PROJECT_BINARY_DIR}/package/KinoraConfig.cmake @ONLY)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/KinoraConfigVersion.cmake
                                   VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/package/KinoraConfig.cmake ${PROJECT_BINARY_DIR}/package/KinoraConfigVersion.cmake
          DESTINATION lib/cmake/Kinora)
endfunction()
