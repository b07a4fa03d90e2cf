// The measured distribution that a light names by iesProfile, as a node of the stock light filter IesLightFilter.
#pragma once
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/file_contents.h"
#include "scene/scene.h"

namespace kinora::render {

// Where a profile's file stands; "" where it is nowhere.
std::string placeOfProfile(const std::string& name, const std::vector<std::string>& searchPath);

// Null without a profile, and with a message where its file is missing or broken: the light then shines as if it named
// none.
scene::NodePtr iesFilterOf(const scene::Node& light, const std::vector<std::string>& searchPath,
                           FileContents& contents, Diagnostics& diagnostics);

}  // namespace kinora::render
