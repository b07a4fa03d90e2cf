// What an edit may have left in a description that no file can say: empty places in lists, transforms whose times and
// matrices do not belong together. Called by Renderer before a world is built of it.
#pragma once
#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::render {

// Takes it out of the scene, or puts what is nearest in its place, each with a message.
void checkScene(scene::Scene& scene, Diagnostics& diagnostics);

}  // namespace kinora::render
