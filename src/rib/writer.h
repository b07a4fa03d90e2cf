// Writes a scene description as ASCII RIB that reads back to the same description (ids, source positions and comments
// aside). Called by app/ (`kinora rib`) and by the round-trip test. It writes no binary RIB and opens no file.
#pragma once
#include <functional>
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace kinora::rib {

// Pieces of text in order, each of bounded size.
using TextSink = std::function<void(std::string_view)>;
void writeRib(const scene::Scene& scene, const TextSink& sink);
std::string writeRib(const scene::Scene& scene);

}  // namespace kinora::rib
