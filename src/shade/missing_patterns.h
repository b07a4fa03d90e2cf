// What stands for a pattern that the scene names and nobody has: files are passed on without the shaders of their
// studio, and what they say of colour and images tells more of the look than a default does.
#pragma once
#include <optional>
#include <string>

#include "scene/scene.h"

namespace kinora::shade {

// The colour parameter of `missing` that its colour `output` takes: the one whose name differs from the output's by
// "in" for "out" (Cin, Cout), else, where no image is named, the first colour. A reference passes on what feeds it.
// Null where there is none.
const scene::Parameter* colorOfMissing(const scene::Node& missing, const std::string& output);

// A PxrTexture of the first image file that `missing` names (by its extension), for a node that has no colour of an
// output's name (see colorOfMissing). Its handle and position stay; values are read as they are stored, as by texture()
// in a shader.
std::optional<scene::Node> textureOfMissing(const scene::Node& missing);

// What a message says of the two.
std::string describeStandIn(const scene::Node& missing);

}  // namespace kinora::shade
