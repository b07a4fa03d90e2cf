// How much memory parts of a description hold. Used by the reader, which counts while it reads, and by the builder.
#pragma once
#include <cstddef>

#include "scene/scene.h"

namespace kinora::scene {

size_t bytesHeld(const Primitive& primitive);

}  // namespace kinora::scene
