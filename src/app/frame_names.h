// Names of files of several frames: `####` stands for the padded frame number. Used by the render command; it touches
// no file.
#pragma once
#include <string>

namespace kinora::app {

bool hasFrameField(const std::string& name);
// Replaces each run of # by the number with at least as many digits: "a.####.exr", 7 -> "a.0007.exr".
std::string withFrame(const std::string& name, int frame);

}  // namespace kinora::app
