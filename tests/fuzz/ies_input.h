// One fuzzing input for the reader of IES profiles: the text of a file. Used by the fuzzer and its short test.
#pragma once
#include <string_view>

namespace kinora::fuzz {

// Reads it, and looks at what was read: tables of the sizes that their angles say, angles that rise, values that a
// light can shine with; or a message with a line of the file. Anything else aborts the process. Returns 1 when the
// text was refused, else 0.
size_t readIesInput(std::string_view text);

}  // namespace kinora::fuzz
