// The message codes of film/, explained: pictures, their channels and displays, and parts of frames. Added to the others by app/explanations.cpp.
#pragma once
#include <span>

#include "base/explain.h"

namespace kinora::film {

std::span<const Explanation> explanations();

}  // namespace kinora::film
