// Values that nodes of a network show in display channels: PxrTee in the one that it names, PxrMatteID in MatteID0 ...
// MatteID7. Asked by render/ at camera hits.
#pragma once
#include <kinora/context.h>

#include <string_view>

namespace kinora::shade {

class MaterialSet;

// What the node for `channel` hands on at the points of a context; components 0: their program has no such node.
Value teeValue(const Context* c, std::string_view channel);
// Whether any material has such a node.
bool hasTee(const MaterialSet& materials, std::string_view channel);

}  // namespace kinora::shade
