// Reads the text assembly that OSL compilers write (.oso; reference: osl-numerics, section 12) into the intermediate
// form. Jumps become the tree of program.h. Nothing in the text is trusted: sizes are checked before memory is taken.
#pragma once
#include <string>
#include <string_view>

#include "language/program/program.h"

namespace kinora::language {

// False with `error` = "file:line: error: what" when the text is not a shader of version 1.00. Thread-safe.
bool readOso(std::string_view text, std::string_view fileName, Shader& shader, std::string& error);

}  // namespace kinora::language
