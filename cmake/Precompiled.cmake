# Headers that most files include, compiled once for each set of compiler flags: parsing them again in every file was
# about half of the build's time. Files still include what they use; the debug and asan presets switch this off, so
# that a file that forgets one fails there. Off also where ccache is found, which misses after every such header anew.
if(CCACHE)
  option(KINORA_PRECOMPILE "Precompile the headers that most files include" OFF)
else()
  option(KINORA_PRECOMPILE "Precompile the headers that most files include" ON)
endif()

set(KINORA_COMMON_HEADERS
    <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <cstdio> <cstring> <filesystem> <fstream> <functional> <limits>
    <map> <memory> <mutex> <optional> <random> <set> <span> <sstream> <string> <string_view> <unordered_map> <utility>
    <variant> <vector> <ImathBox.h> <ImathMatrix.h> <ImathVec.h>)

# Tests call code that is optimised fully; their own runs once, and is compiled a third faster like this.
set(KINORA_TEST_OPTIONS -O1)

# A compilation of ours takes a few hundred megabytes: collecting garbage before that only costs time, 8 % of it.
if(KINORA_PRECOMPILE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options(--param=ggc-min-heapsize=524288)
endif()

# One target owns each set and the others reuse it; libraries are position independent, programs are not quite (-fPIE).
if(KINORA_PRECOMPILE)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/precompiled_main.cpp CONTENT "int main() { return 0; }\n")
  add_library(kinora_precompiled_library STATIC ${PROJECT_BINARY_DIR}/generated/precompiled_main.cpp)
  target_link_libraries(kinora_precompiled_library PRIVATE PkgConfig::IMATH Threads::Threads)
  target_precompile_headers(kinora_precompiled_library PRIVATE ${KINORA_COMMON_HEADERS})
  if(KINORA_BUILD_TESTS)
    add_executable(kinora_precompiled_test ${PROJECT_BINARY_DIR}/generated/precompiled_main.cpp)
    target_link_libraries(kinora_precompiled_test PRIVATE PkgConfig::IMATH GTest::gtest Threads::Threads)
    target_compile_options(kinora_precompiled_test PRIVATE ${KINORA_TEST_OPTIONS})
    target_precompile_headers(kinora_precompiled_test PRIVATE ${KINORA_COMMON_HEADERS} <gtest/gtest.h>)
  endif()
endif()

# kinora_is_kernel(FILE RESULT): whether a file compiles itself once for each target.
function(kinora_is_kernel source result)
  file(STRINGS ${source} found REGEX "foreach_target" LIMIT_COUNT 1)
  if(found)
    set(${result} TRUE PARENT_SCOPE)
  else()
    set(${result} FALSE PARENT_SCOPE)
  endif()
endfunction()

# Files compiled as one, up to so many: what their headers cost is then paid once (the commands took 206 s of CPU, and
# take 40). Where headers are precompiled only: work on one file should compile that file. Kernels, which compile
# themselves once for each target, stay alone. Names inside a file must differ from those of its neighbours.
function(kinora_unity target most)
  if(KINORA_PRECOMPILE)
    get_target_property(sources ${target} SOURCES)
    foreach(source ${sources})
      if(source MATCHES "\\.cpp$" AND EXISTS ${source})
        kinora_is_kernel(${source} kernel)
        if(kernel)
          set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
        endif()
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${most})
  endif()
endfunction()

# kinora_precompiled(TARGET library|test)
function(kinora_precompiled target set)
  if(set STREQUAL "test")
    target_compile_options(${target} PRIVATE ${KINORA_TEST_OPTIONS})
  endif()
  if(KINORA_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM kinora_precompiled_${set})
  endif()
endfunction()
