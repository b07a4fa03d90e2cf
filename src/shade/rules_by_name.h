// What holds for plug-ins by their names, or by those of their parameters, whichever has them: which nodes show values in
// channels, how lobes are called, which colour stands for a bxdf that nobody has. Asked by MaterialSet, whose own rules of
// the kind (structs and their members, layers that are none, colours of shadows) are in the same file. Plug-ins that stand
// for others are in legacy_bxdfs.h, missing_patterns.h and standard_shaders.h.
#pragma once
#include <string_view>

#include "shade/material.h"

namespace kinora::shade {

// Of PxrTee the number goes to the channel where nothing reads the colour. Outputs of PxrMatteID are named as their
// channels are.
void findTees(Program& p);

// The name of a lobe: "=lobeName:Diffuse" is the text of the bxdf's parameter lobeName, or Diffuse where that is empty.
std::string_view lobeName(const LobeDecl& lobe, const ProgramNode& bxdf);

// The colour that keeps the look of a missing material, or a reference to what feeds it; null: it says none.
const scene::Parameter* colorOfMissingBxdf(const scene::Node& bxdf);

}  // namespace kinora::shade
