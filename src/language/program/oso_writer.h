// A shader as .oso text, as OSL's own compiler lays it out (reference: osl-numerics, section 12). Used by `kinora
// shader compile`. Opcodes of ours (kOpOwn) are written under our names: readers of other renderers do not know them.
#pragma once
#include <string>

#include "language/program/program.h"

namespace kinora::language {

std::string osoText(const Shader& shader);

}  // namespace kinora::language
