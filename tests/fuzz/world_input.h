// One fuzzing input for what makes a world of a scene: RIB as rib_input.h has it, then the scene's objects placed, its
// shapes tessellated, its solids composed and rays traced through them. Used by the fuzzer and its short test.
#pragma once
#include <string_view>

namespace kinora::fuzz {

// Aborts the process when a mesh points beyond its own tables, or when a ray meets what is not there. Returns how many
// triangles and pieces of strands there were.
size_t buildWorldInput(std::string_view rib);

}  // namespace kinora::fuzz
