// The message codes of shade/, explained: materials, patterns and shaders. Added to the others by app/explanations.cpp.
#pragma once
#include <span>

#include "base/explain.h"

namespace kinora::shade {

std::span<const Explanation> explanations();

}  // namespace kinora::shade
