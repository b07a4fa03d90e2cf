// Which parameters of a shader decide what its code is, and which are numbers like any other. Asked by the renderer:
// materials that differ in the latter alone share one program.
#pragma once
#include <vector>

#include "language/program/program.h"

namespace kinora::language {

// By symbol, for ints and strings: true where a condition, a loop's end, an index or an option of a call depends on
// it. What is false is merely computed with: an int in arithmetic and hashes, a string that names a texture.
std::vector<bool> structuralSymbols(const Shader&);

}  // namespace kinora::language
