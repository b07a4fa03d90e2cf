# A room is a folder of src/, with folders inside where it is large; its library takes every *.cpp but *_test.cpp,
# *_main.cpp, main.cpp and those of a folder module/ (kinora_picture_library) and of rib/ri/ (kinora_procedural_host). Tests beside the
# code are gathered by kinora_tests(), so that adding a file to a room needs no edit here. SHARED: what it knows (memory
# charged, colours) is one for the program and the picture library.
function(kinora_library name)
  cmake_parse_arguments(R "SHARED" "" "DEPENDS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp ${PROJECT_SOURCE_DIR}/src/${name}/*/*.cpp)
  list(FILTER sources EXCLUDE REGEX "(_test|_main|/main)\\.cpp$|/module/|/rib/ri/")
  kinora_sanitize(${sources})
  if(sources)
    if(R_SHARED)
      add_library(kinora_${name} SHARED ${sources})
      set_target_properties(kinora_${name} PROPERTIES CXX_VISIBILITY_PRESET default
                                                      LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
    else()
      add_library(kinora_${name} STATIC ${sources})
    endif()
    target_include_directories(kinora_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/include)
    target_link_libraries(kinora_${name} PUBLIC ${R_DEPENDS} PkgConfig::HWY Threads::Threads)
    if(NOT name STREQUAL "app")
      kinora_precompiled(kinora_${name} library)
    endif()
    if(name MATCHES "^(app|film|geometry|image|language|plugin|render|rib|scene|shade|testing|trace)$")
      kinora_unity(kinora_${name} 14)
    endif()
  else()
    add_library(kinora_${name} INTERFACE)
    target_include_directories(kinora_${name} INTERFACE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/include)
    target_link_libraries(kinora_${name} INTERFACE ${R_DEPENDS} PkgConfig::HWY Threads::Threads)
  endif()
endfunction()

# What calls OpenImageIO, and with it 260 shared libraries: loaded when the first picture is opened
# (src/image/picture_library.h), from beside kinora_image. The objects are also for tests of its files.
function(kinora_picture_library)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/*/module/*.cpp)
  kinora_sanitize(${sources})
  add_library(kinora_picture_objects OBJECT ${sources})
  target_include_directories(kinora_picture_objects PUBLIC ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/include)
  target_link_libraries(kinora_picture_objects PUBLIC kinora_texture kinora_volume kinora_image OpenImageIO::OpenImageIO)
  kinora_precompiled(kinora_picture_objects library)
  kinora_unity(kinora_picture_objects 8)
  add_library(kinora_pictures MODULE $<TARGET_OBJECTS:kinora_picture_objects>)
  target_link_libraries(kinora_pictures PRIVATE kinora_picture_objects)
  set_target_properties(kinora_pictures PROPERTIES LINKER_LANGUAGE CXX LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
endfunction()

# Stock plug-ins: one folder each, plugins/<kind>/<Name>/<Name>.cpp. They see the public headers only. The table that
# lists them is generated, so a new folder is all a new plug-in needs.
function(kinora_stock_plugins)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/plugins/*/*/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  kinora_sanitize(${sources})
  set(declarations "")
  set(entries "")
  set(own_sources "")
  foreach(source ${sources})
    get_filename_component(folder ${source} DIRECTORY)
    get_filename_component(name ${folder} NAME)
    get_filename_component(file ${source} NAME_WE)
    if(file STREQUAL name)
      string(APPEND declarations "const Descriptor* kinoraStock_${name}();\n")
      string(APPEND entries "  list.push_back(kinoraStock_${name}());\n")
    endif()
  endforeach()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/stock_plugins.cpp CONTENT
"// Generated from the folders of plugins/; see cmake/Libraries.cmake.
#include \"plugin/registry.h\"
namespace kinora {
@declarations@
std::vector<const Descriptor*> stockPlugins() {
  std::vector<const Descriptor*> list;
@entries@  return list;
}
}  // namespace kinora
" @ONLY)
  # objects, not an archive: every plug-in is linked although only the table names it
  add_library(kinora_stock_objects OBJECT ${sources})
  target_compile_definitions(kinora_stock_objects PRIVATE KINORA_STOCK_PLUGIN)
  target_include_directories(kinora_stock_objects PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR})
  target_link_libraries(kinora_stock_objects PRIVATE PkgConfig::HWY PkgConfig::OPENEXR)
  kinora_precompiled(kinora_stock_objects library)
  add_library(kinora_stock STATIC ${PROJECT_BINARY_DIR}/generated/stock_plugins.cpp $<TARGET_OBJECTS:kinora_stock_objects>)
  target_link_libraries(kinora_stock PUBLIC kinora_plugin PkgConfig::OPENEXR)
  # the registry calls the generated table and the table's file includes the registry: each archive names the other
  target_link_libraries(kinora_plugin INTERFACE kinora_stock)
endfunction()

# The program. Everything but main.cpp is the library kinora_app, so that tests link it.
function(kinora_app)
  kinora_library(app DEPENDS kinora_render kinora_rib kinora_film kinora_language kinora_stock CLI11::CLI11 fmt::fmt
                          nlohmann_json::nlohmann_json)
  # commands run once: their headers and their optimisation would be a tenth of the build's time
  target_compile_options(kinora_app PRIVATE -O1)
  if(KINORA_PRECOMPILE)
    target_precompile_headers(kinora_app PRIVATE ${KINORA_COMMON_HEADERS} <CLI/App.hpp> <CLI/Config.hpp> <CLI/Formatter.hpp>
                                                 <fmt/format.h> <nlohmann/json.hpp>)
  endif()
  add_executable(kinora ${PROJECT_SOURCE_DIR}/src/app/main.cpp)
  target_link_libraries(kinora PRIVATE kinora_app)
  add_dependencies(kinora kinora_pictures)
  set_target_properties(kinora PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
endfunction()

# The testing kit's program, for authors of plug-ins.
function(kinora_check_plugin)
  add_executable(kinora-check-plugin ${PROJECT_SOURCE_DIR}/src/testing/check_plugin_main.cpp)
  target_link_libraries(kinora-check-plugin PRIVATE kinora_testing kinora_stock kinora_plugin)
  install(TARGETS kinora-check-plugin RUNTIME DESTINATION bin)
endfunction()

# Runs shared objects of Procedural "DynamicLoad": its functions are theirs to call.
function(kinora_procedural_host)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/rib/ri/*.cpp)
  kinora_sanitize(${sources})
  add_executable(kinora-procedural ${sources})
  target_link_libraries(kinora-procedural PRIVATE kinora_rib CLI11::CLI11 ${CMAKE_DL_LIBS})
  set_target_properties(kinora-procedural PROPERTIES ENABLE_EXPORTS ON RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
  add_dependencies(kinora kinora-procedural)
endfunction()

# The benchmarks: a program of its own over the whole renderer.
function(kinora_bench)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/bench/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  add_executable(kinora-bench ${sources})
  target_link_libraries(kinora-bench PRIVATE kinora_render kinora_rib kinora_language kinora_testing kinora_stock CLI11::CLI11
                                             nlohmann_json::nlohmann_json OpenImageIO::OpenImageIO OpenVDB::openvdb)
  add_dependencies(kinora-bench kinora_pictures)
  target_compile_definitions(kinora-bench PRIVATE KINORA_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  kinora_unity(kinora-bench 8)
  set_target_properties(kinora-bench PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
endfunction()

# A test program that sees the testing kit and all stock plug-ins.
function(kinora_test_program name)
  add_executable(test_${name} ${ARGN})
  target_link_libraries(test_${name} PRIVATE kinora_testing kinora_plugin kinora_stock kinora_plugin GTest::gtest_main GTest::gtest)
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR})
  add_dependencies(test_${name} kinora_pictures)
  kinora_precompiled(test_${name} test)
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}. DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
endfunction()

# Tests: one program per room (src/<room>/*_test.cpp), one per kind of plug-in, and the folders of
# tests/: a folder with a CMakeLists.txt says itself what it needs, any other is one program over the whole renderer.
function(kinora_tests)
  include(GoogleTest)
  file(GLOB rooms RELATIVE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/src/*)
  foreach(room ${rooms})
    file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${room}/*_test.cpp ${PROJECT_SOURCE_DIR}/src/${room}/*/*_test.cpp)
    if(sources)
      add_executable(test_${room} ${sources})
      target_link_libraries(test_${room} PRIVATE kinora_${room} GTest::gtest_main GTest::gtest)
      target_compile_definitions(test_${room} PRIVATE KINORA_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
      add_dependencies(test_${room} kinora_pictures)
      if(room STREQUAL "texture")
        target_sources(test_texture PRIVATE $<TARGET_OBJECTS:kinora_picture_objects>)
        target_link_libraries(test_texture PRIVATE kinora_picture_objects)
      endif()
      kinora_precompiled(test_${room} test)
      if(room MATCHES "^(app|film|geometry|rib|scene|texture)$")
        kinora_unity(test_${room} 8)
      endif()
      if(room STREQUAL "film")
        # the stock display drivers alone: film/ is tested with them, and needs no other plug-in
        file(GLOB drivers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/plugins/display/*/*.cpp)
        target_sources(test_film PRIVATE ${drivers})
        set_source_files_properties(${drivers} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
        target_compile_definitions(test_film PRIVATE KINORA_STOCK_PLUGIN)
      endif()
      gtest_discover_tests(test_${room} TEST_PREFIX ${room}. DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
    endif()
  endforeach()
  # what tests of the whole renderer share
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/support/*.cpp)
  add_library(kinora_test_support STATIC ${sources})
  target_include_directories(kinora_test_support PUBLIC ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(kinora_test_support PUBLIC KINORA_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(kinora_test_support PUBLIC kinora_render kinora_rib kinora_testing kinora_stock GTest::gtest)
  kinora_precompiled(kinora_test_support library)
  file(GLOB folders RELATIVE ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/tests/*)
  foreach(folder ${folders})
    file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/${folder}/*_test.cpp)
    if(EXISTS ${PROJECT_SOURCE_DIR}/tests/${folder}/CMakeLists.txt)
      add_subdirectory(${PROJECT_SOURCE_DIR}/tests/${folder} ${PROJECT_BINARY_DIR}/tests/${folder})
    elseif(sources)
      kinora_test_program(${folder} ${sources})
      if(folder MATCHES "^(channels|patterns)$")
        kinora_unity(test_${folder} 8)
      endif()
      target_link_libraries(test_${folder} PRIVATE kinora_test_support)
      if(folder STREQUAL "probes")
        target_sources(test_probes PRIVATE ${PROJECT_SOURCE_DIR}/tests/probes/wrong_walks.cpp
          ${PROJECT_SOURCE_DIR}/tests/probes/wrong_guides.cpp ${PROJECT_SOURCE_DIR}/tests/probes/wrong_lights.cpp
          ${PROJECT_SOURCE_DIR}/tests/probes/wrong_beams.cpp)
        # examples that are judged by their pictures; tests/install builds them as their users do
        foreach(name OneConnection Puff Haze)
          set(example ${PROJECT_SOURCE_DIR}/examples/plugins/${name}.cpp)
          set_source_files_properties(${example} PROPERTIES COMPILE_DEFINITIONS KINORA_STOCK_PLUGIN
            INCLUDE_DIRECTORIES ${PROJECT_SOURCE_DIR}/examples/plugins SKIP_UNITY_BUILD_INCLUSION ON)
          target_sources(test_probes PRIVATE ${example})
        endforeach()
      endif()
    endif()
  endforeach()
  # one program a kind: a program for each plug-in spent a minute of the build on linking
  file(GLOB kinds RELATIVE ${PROJECT_SOURCE_DIR}/plugins ${PROJECT_SOURCE_DIR}/plugins/*)
  foreach(kind ${kinds})
    file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/plugins/${kind}/*/*_test.cpp)
    if(sources)
      kinora_test_program(plugins_${kind} ${sources})
    endif()
  endforeach()
  add_test(NAME check_floors COMMAND ${PROJECT_SOURCE_DIR}/tools/check_floors)
endfunction()
