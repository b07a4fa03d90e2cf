// One fuzzing input for the shading language's front end: source, and after lines "##file NAME" the files that it may
// include. Used by the fuzzer and its short test.
#pragma once
#include <string>
#include <string_view>

namespace kinora::fuzz {

// Preprocesses and compiles. What compiles must be a valid program, and its .oso must be read as the same program:
// otherwise the process is aborted. Returns the number of messages.
size_t compileOslInput(std::string_view bytes);

}  // namespace kinora::fuzz
