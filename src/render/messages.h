// The message codes of render/, explained: the frame, its camera, lights, media and displacement; with those of the light and filter plug-ins. Added to the others by app/explanations.cpp.
#pragma once
#include <span>

#include "base/explain.h"

namespace kinora::render {

std::span<const Explanation> explanations();

}  // namespace kinora::render
