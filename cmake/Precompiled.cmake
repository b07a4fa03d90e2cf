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

# kinora_precompiled(TARGET library|test)
function(kinora_precompiled target set)
  if(set STREQUAL "test")
    target_compile_options(${target} PRIVATE ${KINORA_TEST_OPTIONS})
  endif()
  if(KINORA_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM kinora_precompiled_${set})
  endif()
endfunction()
